"""Surfaces of bodies for pictures: extruded beams, faces of meshes, bars between nodes."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from ..math.arrays import Array, IntArray
from ..math.shortest_rotation import shortest_rotations
from .outline import Outline
from .view import Surface

LINES = (3, 4, 21)  # VTK cell types: line, polyline, quadratic edge
# Faces, by corners, of VTK cell types; higher orders start with the same corners.
_TETRA = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
_HEXA = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_WEDGE = ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0))
_PYRAMID = ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))
_THREE, _FOUR = ((0, 1, 2),), ((0, 1, 2, 3),)
FACES = {5: _THREE, 22: _THREE, 9: _FOUR, 23: _FOUR, 28: _FOUR, 10: _TETRA, 24: _TETRA}
FACES |= {12: _HEXA, 25: _HEXA, 29: _HEXA, 13: _WEDGE, 26: _WEDGE, 14: _PYRAMID, 27: _PYRAMID}
SOLID = (10, 24, 12, 25, 29, 13, 26, 14, 27)


FLAT = 12  # sides of a section whose edges along the beam are drawn


class Parts:
    """A surface that grows by quadrilaterals, triangles and points."""

    def __init__(self) -> None:
        self._node: list[IntArray] = []
        self._offset: list[Array] = []
        self._triangles: list[IntArray] = []
        self._edges: list[IntArray] = []
        self._site: list[IntArray] = []
        self._count = 0

    def points(self, node: IntArray, offset_B: Array) -> int:
        """Add points; return the row of the first."""
        self._node.append(np.asarray(node))
        self._offset.append(np.asarray(offset_B, dtype=float).reshape(-1, 3))
        first, self._count = self._count, self._count + len(node)
        return first

    def triangles(self, corners: IntArray, edges: IntArray, site: IntArray) -> None:
        """Add triangles (f, 3) of points, their drawn edges (f,) and sites (f, 3)."""
        self._triangles.append(corners)
        self._edges.append(edges)
        self._site.append(site)

    def quads(self, corners: IntArray, site: IntArray, *, sides: int = 0b1111) -> None:
        """Add quadrilaterals (f, 4) with sites (f, 4); bits of `sides`: drawn edges 01 12 23 30."""
        count = len(corners)
        one = (sides & 1) | (sides & 2)
        two = ((sides >> 2) & 1) << 1 | ((sides >> 3) & 1) << 2
        for pick, drawn in (((0, 1, 2), one), ((0, 2, 3), two)):
            self.triangles(corners[:, pick], np.full(count, drawn), site[:, pick])

    def surface(self) -> Surface:
        """Return what was added."""

        def joined(parts: list[IntArray], *shape: int) -> IntArray:
            return np.concatenate([np.zeros((0, *shape), dtype=np.int64), *parts])

        offset = np.concatenate([np.zeros((0, 3)), *self._offset])
        triangles, site = joined(self._triangles, 3), joined(self._site, 3)
        return Surface(joined(self._node), offset, triangles, joined(self._edges), site)


def extruded(
    nodes_B: Array, outlines: Sequence[Outline], axes_B: Array, ends: IntArray, starts: IntArray
) -> Surface:
    """Extrude outlines along the nodes of a beam.

    Parameters
    ----------
    nodes_B : (n, 3), in order along the beam
    outlines : one for all elements, or n - 1
    axes_B : (n, 3, 3) section axes of each node in body axes
    ends, starts : (n,) sites of each node as end of an element and as start of one
    """
    parts, n = Parts(), len(nodes_B)
    sites = np.column_stack([starts[:-1], ends[1:]])
    own = [outlines[min(e, len(outlines) - 1)] for e in range(n - 1)]
    for _, some in groupby(range(n - 1), lambda e: id(own[e])):  # elements of one outline
        e = np.array(list(some))
        _add_tubes(parts, _tube(own[e[0]]), e, axes_B, sites[e])
    for node, outline, turn, site in (
        (0, outlines[0], (0, 2, 1), starts[0]),
        (n - 1, outlines[-1], (0, 1, 2), ends[n - 1]),
    ):
        used, rows = np.unique(outline.face, return_inverse=True)
        flat = np.column_stack([np.zeros(len(used)), outline.points[used]])
        first = parts.points(np.full(len(used), node), flat @ axes_B[node].T)
        face = first + rows.reshape(-1, 3)[:, turn]
        parts.triangles(face, np.zeros(len(face), dtype=np.int64), np.full(face.shape, site))
    return parts.surface()


def _tube(outline: Outline) -> Surface:
    """Return the walls between nodes 0 and 1, offsets in section axes; sites are those numbers."""
    parts = Parts()
    for loop in outline.loops:
        count = len(loop)
        flat = np.column_stack([np.zeros(count), outline.points[loop]])
        k = parts.points(np.repeat([0, 1], count), np.concatenate([flat, flat])) + np.arange(count)
        there = np.roll(k, -1)
        corners = np.column_stack([k, k + count, there + count, there])
        site = np.tile([0, 1, 1, 0], (count, 1))
        parts.quads(corners, site, sides=0b0001 if count <= FLAT else 0)
    return parts.surface()


def _add_tubes(parts: Parts, tube: Surface, e: IntArray, axes_B: Array, sites: IntArray) -> None:
    """Add a tube for each of the elements e (k,), which follow each other; sites (k, 2)."""
    at = tube.offset_B @ axes_B[e[0] : e[-1] + 2].transpose(0, 2, 1)
    offset_B = np.where(tube.node[:, None] == 0, at[:-1], at[1:])
    first = parts.points((e[:, None] + tube.node).ravel(), offset_B)
    of_each = first + len(tube.node) * np.arange(len(e))
    parts.triangles(
        (of_each[:, None, None] + tube.triangles).reshape(-1, 3),
        np.tile(tube.edges, len(e)),
        sites[:, tube.site].reshape(-1, 3),
    )


def faces(
    connectivity: IntArray, offsets: IntArray, cell_types: IntArray, site: IntArray
) -> Surface:
    """Return the cells of surfaces and the outer faces of solids; `site` (c,) of each cell."""
    found: dict[int, list[tuple[IntArray, IntArray]]] = {3: [], 4: []}
    for kind in np.unique(cell_types).tolist():
        own = np.flatnonzero(cell_types == kind)
        shapes = FACES.get(int(kind), ())
        sides = [
            (connectivity[offsets[own][:, None] + np.array(shape)], site[own]) for shape in shapes
        ]
        for count in (3, 4):
            some = [side for side in sides if side[0].shape[1] == count]
            if some:
                corners = np.concatenate([c for c, _ in some])
                sites = np.concatenate([s for _, s in some])
                if kind in SOLID:
                    _, first, number = np.unique(
                        np.sort(corners, axis=1), axis=0, return_index=True, return_counts=True
                    )
                    outer = first[number == 1]
                    corners, sites = corners[outer], sites[outer]
                found[count].append((corners, sites))
    parts = Parts()
    used = [corners for some in found.values() for corners, _ in some]
    nodes = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(c.ravel() for c in used)]))
    parts.points(nodes, np.zeros((len(nodes), 3)))
    for corners, sites in found[3]:
        rows = np.searchsorted(nodes, corners)
        parts.triangles(rows, np.full(len(rows), 7), np.repeat(sites[:, None], 3, axis=1))
    for corners, sites in found[4]:
        parts.quads(np.searchsorted(nodes, corners), np.repeat(sites[:, None], 4, axis=1))
    return parts.surface()


def square(width: float) -> Outline:
    """Return a square section."""
    h = 0.5 * width
    corners = np.array([[-h, -h], [h, -h], [h, h], [-h, h]])
    return Outline(corners, (np.arange(4),), np.array([(0, 1, 2), (0, 2, 3)]))


def spokes(nodes_B: Array, width: float) -> Surface:
    """Return square bars from the first node to each of the others."""
    parts = Parts()
    add_bars(parts, nodes_B, width)
    return parts.surface()


def add_bars(parts: Parts, nodes_B: Array, width: float) -> None:
    """Add square bars from the first node to each of the others."""
    along = nodes_B - nodes_B[0]
    length = np.linalg.norm(along, axis=1)
    ends = np.flatnonzero(length > 1e-9)
    if not len(ends):
        return
    e1 = along[ends] / length[ends, None]
    e2 = np.cross(e1, np.eye(3)[np.argmin(np.abs(e1), axis=1)])
    e2 /= np.linalg.norm(e2, axis=1)[:, None]
    across = np.stack([e2, np.cross(e1, e2)], axis=1)  # (bars, 2, 3)
    outline = square(width)
    corners = outline.points @ across
    nodes = np.repeat(np.column_stack([np.zeros_like(ends), ends]), 4, axis=1)
    one = parts.points(nodes.ravel(), np.concatenate([corners, corners], axis=1).reshape(-1, 3))
    loop, two = outline.loops[0], outline.loops[0] + 4
    there = np.roll(loop, -1)
    sides = np.column_stack([loop, two, there + 4, there])
    faces = np.concatenate([sides, loop[None, ::-1], two[None]])
    quads = (one + 8 * np.arange(len(ends)))[:, None, None] + faces
    parts.quads(quads.reshape(-1, 4), np.full((len(ends) * len(faces), 4), -1))


def frames_along(nodes_B: Array, first_B: Array | None) -> Array:
    """Axes (n, 3, 3) at the nodes of a line, e1 along it, turned as little as possible.

    first_B : (3, 3) axes at the first node; None: any with e1 along the line
    """
    steps = np.diff(nodes_B, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    tangents = np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    if first_B is None:
        side = np.eye(3)[int(np.argmin(np.abs(tangents[0])))]
        e2 = np.cross(tangents[0], side)
        e2 /= np.linalg.norm(e2)
        first_B = np.column_stack([tangents[0], e2, np.cross(tangents[0], e2)])
    found = [first_B]
    for turn in shortest_rotations(tangents[:-1], tangents[1:]):
        found.append(turn @ found[-1])
    return np.array(found)
