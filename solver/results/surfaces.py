"""Surfaces of bodies for pictures: extruded beams, faces of meshes, bars, boxes, spheres."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..math.arrays import Array, IntArray, distinct
from ..math.rotations import rotation_matrices, shortest_rotations
from ..math.rows import ComputedRows, computed
from ..package.common.cells import SOLID_FACES, corners_of
from .outline import Outline
from .run_result import BodyGeometry, Surface

# Positions of drawn points from the coordinates of their body.

MANY = 16  # rigid bodies that are moved together
MOST_STORED = 100_000_000  # bytes of positions that a result file has in any case


def node_positions(
    q: Array, first: int, nodes_B: Array, shapes_B: Array, out: Array | None = None
) -> Array:
    """Return global positions (k, n, 3) of nodes. Paper: Eq. (15).

    First order in the modes, also for a stiffened body; for pictures.

    Parameters
    ----------
    q : (k, n_pos) coordinates of the mechanism
    first : column of the body's r_G (3), Euler parameters (4), then modal coordinates (m)
    nodes_B : (n, 3) rest positions [m]
    shapes_B : (m, n, 3) translations per unit mode [m]
    out : (k, n, 3) to fill; None: a new array
    """
    positions = np.empty((len(q), len(nodes_B), 3)) if out is None else out
    # Time is the last axis until the end: long rows for NumPy, whatever the number of nodes.
    modal = np.ascontiguousarray(q[:, first + 7 : first + 7 + len(shapes_B)].T)
    x, y, z = (nodes_B[:, a, None] + shapes_B[:, :, a].T @ modal for a in range(3))
    A = np.ascontiguousarray(rotation_matrices(q[:, first + 3 : first + 7]).transpose(1, 2, 0))
    for a, (along_x, along_y, along_z) in enumerate(A):
        place = along_x * x
        place += along_y * y
        place += along_z * z
        place += q[:, first + a]
        positions[:, :, a] = place.T
    return positions


Moved = tuple[int, Array, Array]  # first, nodes_B, shapes_B of a body, as above


def all_positions(q: Any, bodies: Sequence[Moved]) -> Any:
    """Return the positions (k, n, 3) of all bodies end to end, computed when read if q is long."""

    count = sum(len(nodes) for _, nodes, _ in bodies)

    starts = np.cumsum([0] + [len(nodes) for _, nodes, _ in bodies])
    rigid = [i for i, (_, _, shapes) in enumerate(bodies) if not len(shapes)]
    # Many rigid bodies together: each has few nodes. It takes more memory for each of them.
    rigid = rigid if len(rigid) > MANY else []
    single = sorted(set(range(len(bodies))) - set(rigid))
    sizes = [len(bodies[i][1]) for i in rigid]
    of_rigid = _joined([np.arange(starts[i], starts[i + 1]) for i in rigid], 0).astype(int)
    nodes_B = _joined([bodies[i][1] for i in rigid], 3)
    columns = np.array([bodies[i][0] for i in rigid], dtype=int)[:, None] + np.arange(7)

    def points(first: int, end: int) -> Array:
        some = q[first:end]
        positions = np.empty((len(some), count, 3))
        for i in single:
            node_positions(some, *bodies[i], positions[:, starts[i] : starts[i + 1]])
        if rigid:
            at = some[:, columns]
            A = rotation_matrices(at[..., 3:].reshape(-1, 4)).reshape(*at.shape[:2], 3, 3)
            turned = np.einsum("kiab,ib->kia", np.repeat(A, sizes, axis=1), nodes_B)
            positions[:, of_rigid] = turned + np.repeat(at[..., :3], sizes, axis=1)
        return positions

    return computed(q, (len(q), count, 3), points)


def _joined(parts: list[Array], width: int) -> Array:
    return np.concatenate(parts) if parts else np.zeros((0, width) if width else 0)


def drawn_by_views(bodies: Sequence[BodyGeometry]) -> bool:
    """Return whether positions follow from the coordinates: all bodies have views."""
    return bool(bodies) and all(body.view is not None for body in bodies)


def positions_of_views(q: Array, bodies: Sequence[BodyGeometry]) -> ComputedRows:
    """Return the positions (k, n, 3) of bodies with views, computed when they are read."""
    moved = [
        (body.view.first_position, body.nodes_B, body.view.shapes_B[:, :, :3])
        for body in bodies
        if body.view is not None
    ]
    count = sum(len(body.nodes_B) for body in bodies)
    return ComputedRows((len(q), count, 3), lambda a, b: np.asarray(all_positions(q[a:b], moved)))


# Surface of a rigid body for pictures: a box of its inertia, and bars to its places.

THICKER = 1.3  # a box than the bars, at least
LONGEST = 1.2  # edge of a box, over the reach of the mechanism
# Corners of a box by the signs of its half edges, and its faces, outward.
SIGNS = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
BOX = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])


def uniform_box(mass: float, S_B: Array, J_B: Array) -> tuple[Array, Array]:
    """Edges (3,) [m] and axes (3, 3), by columns, of a uniform box with this inertia.

    Parameters
    ----------
    S_B : (3,) first moment of mass about the origin [kg m]
    J_B : (3, 3) inertia about the origin [kg m2]

    Moments of inertia that no solid has give edges of length 0.
    """
    if not mass > 0.0:
        return np.zeros(3), np.eye(3)
    c = S_B / mass
    about_centre = J_B - mass * (c @ c * np.eye(3) - np.outer(c, c))
    moments, axes = np.linalg.eigh(0.5 * (about_centre + about_centre.T))
    with np.errstate(over="ignore"):  # of masses near the smallest number
        squares = 6.0 * (moments.sum() - 2.0 * moments) / mass
    return np.sqrt(np.clip(squares, 0.0, 1e300)), axes * np.sign(np.linalg.det(axes))


def rigid_surface(
    nodes_B: Array, centre_B: Array, edges: Array, axes_B: Array, width: float, reach: float
) -> Surface:
    """Return a box at the centre of mass, and bars from the first node to each of the others.

    Parameters
    ----------
    edges, axes_B : of the box
    width : of the bars [m]
    reach : size of the mechanism, which limits the box [m]
    """
    parts = Parts()
    edges = edges * min(1.0, LONGEST * reach / max(float(edges.max()), 1e-300))
    half = 0.5 * np.maximum(edges, THICKER * width)
    corners = centre_B - nodes_B[0] + (SIGNS * half) @ axes_B.T
    first = parts.points(np.zeros(8, dtype=np.int64), corners)
    parts.quads(first + BOX, np.full(BOX.shape, -1))
    add_bars(parts, nodes_B, width)
    return parts.surface()


def stl_triangles(file: Path) -> Array:
    """Return the triangles (f, 3, 3) of an STL file.

    Raises
    ------
    InputError
        The file is none, or has no triangles.
    """
    import meshio  # takes 0.1 s

    try:
        with np.errstate(all="ignore"):  # of a count that is none
            mesh = meshio.read(file, file_format="stl")
    except Exception as error:  # meshio raises many kinds
        raise InputError(f"{file}: cannot be read as STL: {error}") from None
    rows = mesh.cells_dict.get("triangle", np.zeros((0, 3), dtype=np.int64))
    if not (rows.size and np.isfinite(mesh.points).all()):
        raise InputError(f"{file}: {len(rows)} triangles; expected an STL file with finite ones")
    return np.asarray(mesh.points[rows], dtype=float)


def picture_surface(nodes_B: Array, file: Path) -> Surface:
    """Return the surface of a rigid body as an STL file in its axes has it [m]."""
    points = stl_triangles(file).reshape(-1, 3)
    triangles = np.arange(len(points)).reshape(-1, 3)
    return Surface(
        np.zeros(len(points), dtype=np.int64),
        points - nodes_B[0],
        triangles,
        np.zeros(len(triangles), dtype=np.int64),
        np.full(triangles.shape, -1),
    )


# Spheres on the surface of a body, which stand for point masses.

SIDES = 12  # of the equator
DENSITY = 7850.0  # of the sphere, steel [kg/m3]
LEAST, MOST = 0.012, 0.05  # radius over the size of the mechanism

Ball = tuple[Array, float]  # centre (3,) in body axes [m], mass [kg]


def radius(mass: float, reach: float) -> float:
    """Return the radius [m] of a steel sphere of this mass, in bounds of the picture."""
    of_steel = (3.0 * mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0)
    return float(np.clip(of_steel, LEAST * reach, MOST * reach)) if reach > 0.0 else of_steel


def with_spheres(surface: Surface, nodes_B: Array, balls: Sequence[Ball], reach: float) -> Surface:
    """Return a surface and a sphere for each point mass, moving with the node nearest to it.

    Parameters
    ----------
    nodes_B : (n, 3) nodes of the body [m]
    reach : size of the mechanism [m]
    """
    parts = Parts()
    parts.points(surface.node, surface.offset_B)
    parts.triangles(surface.triangles, surface.edges, surface.site)
    rings, quads = unit_sphere()
    for centre, mass in balls:
        node = int(np.argmin(np.linalg.norm(nodes_B - centre, axis=1)))
        points = centre - nodes_B[node] + radius(mass, reach) * rings
        first = parts.points(np.full(len(points), node), points)
        parts.quads(first + quads, np.full(quads.shape, -1), sides=0)
    return parts.surface()


def unit_sphere(sides: int = SIDES) -> tuple[Array, IntArray]:
    """Points (p, 3) on circles of latitude, poles included, and cells (f, 4), outward."""
    bands = sides // 2
    polar = np.linspace(0.0, np.pi, bands + 1)[:, None]
    around = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)[None, :]
    x, y = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around)
    points = np.stack([x, y, np.cos(polar) * np.ones_like(around)], axis=-1).reshape(-1, 3)
    band, side = np.meshgrid(np.arange(bands), np.arange(sides), indexing="ij")
    next_side = (side + 1) % sides
    corners = [(band, side), (band + 1, side), (band + 1, next_side), (band, next_side)]
    cells = np.stack([b * sides + s for b, s in corners], axis=-1).reshape(-1, 4)
    return points, cells.astype(np.int64)


def prism(sides: int, radius: float, half: float) -> tuple[Array, IntArray]:
    """Points (p, 3) of a prism of length 2 half along z, and its triangles (f, 3), outward.

    Parameters
    ----------
    sides : number of sides
    radius : radius of the corners [m]
    half : half its length [m]
    """
    angle = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * radius
    points = np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (-half, half)])
    k = np.arange(sides)
    there = (k + 1) % sides
    side = halved(np.column_stack([k, there, there + sides, k + sides]))
    fan = np.column_stack([np.zeros(sides - 2, dtype=int), k[1:-1], k[2:]])
    return points, np.concatenate([side, fan[:, ::-1], fan + sides])


def halved(quads: IntArray) -> IntArray:
    """Return the triangles (2 n, 3) of quadrilaterals (n, 4)."""
    return np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


# Surfaces of bodies for pictures: extruded beams, faces of meshes, bars between nodes.

LINES = (3, 4, 21)  # VTK cell types: line, polyline, quadratic edge
# Faces, by corners, of VTK cell types.
FACES = {kind: tuple(map(corners_of, faces)) for kind, faces in SOLID_FACES.items()}
FACES |= {kind: ((0, 1, 2),) for kind in (5, 22)} | {kind: ((0, 1, 2, 3),) for kind in (9, 23, 28)}


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
        """Add triangles (f, 3) of points, their drawn edges (f,) and sites (f, 3).

        Parameters
        ----------
        corners : numbers of points (f, 3)
        edges : bits of the edges that are drawn (f,)
        site : site of each corner (f, 3)
        """
        self._triangles.append(corners)
        self._edges.append(edges)
        self._site.append(site)

    def quads(self, corners: IntArray, site: IntArray, *, sides: int = 0b1111) -> None:
        """Add quadrilaterals (f, 4) with sites (f, 4); bits of `sides`: drawn edges 01 12 23 30.

        Parameters
        ----------
        corners : numbers of points (f, 4)
        site : site of each corner (f, 4)
        sides : bits of the edges 01, 12, 23, 30 that are drawn
        """
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
    """Return the cells of surfaces and the outer faces of solids; `site` (c,) of each cell.

    Parameters
    ----------
    connectivity : nodes of all cells, end to end
    offsets : begin of each cell (c + 1,)
    cell_types : VTK types of the cells (c,)
    site : site of each cell (c,)
    """
    by_corners: dict[int, list[tuple[IntArray, IntArray]]] = {3: [], 4: []}
    for kind in distinct(cell_types).tolist():
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
                if kind in SOLID_FACES:
                    _, first, number = np.unique(
                        np.sort(corners, axis=1), axis=0, return_index=True, return_counts=True
                    )
                    outer = first[number == 1]
                    corners, sites = corners[outer], sites[outer]
                by_corners[count].append((corners, sites))
    parts = Parts()
    used = [corners for some in by_corners.values() for corners, _ in some]
    nodes = distinct(np.concatenate([np.zeros(0, dtype=np.int64), *(c.ravel() for c in used)]))
    parts.points(nodes, np.zeros((len(nodes), 3)))
    for corners, sites in by_corners[3]:
        rows = np.searchsorted(nodes, corners)
        parts.triangles(rows, np.full(len(rows), 7), np.repeat(sites[:, None], 3, axis=1))
    for corners, sites in by_corners[4]:
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
    """Add square bars from the first node to each of the others.

    Parameters
    ----------
    parts : surface to add to
    nodes_B : nodes (n, 3), body axes [m]
    width : side of the square section [m]
    """
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
    frames = [first_B]
    for turn in shortest_rotations(tangents[:-1], tangents[1:]):
        frames.append(turn @ frames[-1])
    return np.array(frames)
