"""Cells of a section: triangles and quadrilaterals of 3 to 9 nodes, mixed in one mesh; refinement.

A refined cell is divided into four. Corners of small cells may hang on edges of large ones.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....solver.math.arrays import Array
from ... import fenicsx
from ...fenicsx import EDGES, NODES, PlainMesh

IntArray = NDArray[np.int64]
KINDS = ("triangle", "quadrilateral")  # kind 0 and 1
ABSENT = -1
MOST_NODES = 9
CORNERS = (3, 4)  # of each kind
OPPOSITE = [2, 3, 0, 1, 6, 7, 4, 5, 8]  # nodes of a quadrilateral, from the opposite corner
FULL = (6, 9)  # nodes of each kind with all middle nodes and the centre


@dataclass(frozen=True, eq=False)  # equal only to itself
class CellMesh:
    """A mesh whose cells may differ in kind and number of nodes; `c` counts cells.

    Attributes
    ----------
    points : (n, 2) [m]
    nodes : (c, 9) rows of points: corners counter-clockwise, middles of the edges in the same order
        from the edge of the first two corners, centre; ABSENT where a cell has no such node
    kind : (c,) row of KINDS
    region : (c,) row of regions
    hanging : (h, 3) ends of an edge of a cell, and the corner of smaller cells in its middle
    layer_angle : (c, 1) or, at all 6 or 9 nodes, (c, 9) angle from x2 to the layer direction [deg],
        if the mesh has it
    """

    points: Array
    nodes: IntArray
    kind: IntArray
    region: IntArray
    regions: tuple[str, ...]
    hanging: IntArray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    layer_angle: Array | None = None

    @property
    def n_cell(self) -> int:
        """Number of cells."""
        return len(self.nodes)

    @property
    def degree(self) -> int:
        """Degree of the geometry: 1 if all cells have corners only."""
        return (
            2
            if any((self.nodes[rows, CORNERS[kind] :] >= 0).any() for kind, rows in self.of_kinds)
            else 1
        )

    @cached_property
    def of_kinds(self) -> list[tuple[int, IntArray]]:
        """Kinds that occur, and the cells of each one."""
        groups = [(kind, np.flatnonzero(self.kind == kind)) for kind in range(len(KINDS))]
        return [(kind, rows) for kind, rows in groups if rows.size]

    @cached_property
    def shapes(self) -> list[Array]:
        """Positions of all 6 or 9 nodes of the cells of each kind in `of_kinds`, (c, 6 or 9, 2).

        A node that a cell does not have lies where its map puts it.
        """
        shapes = []
        for kind, rows in self.of_kinds:
            nodes = self.nodes[rows, : FULL[kind]]
            places = self.points[nodes]  # of absent nodes: meaningless so far
            for pattern, members in patterns(nodes):
                places[members] = np.einsum(
                    "ij,cjx->cix", filling(kind, pattern), places[members][:, pattern]
                )
            shapes.append(places)
        return shapes

    @cached_property
    def is_curved(self) -> bool:
        """True unless the middle nodes lie half way between corners."""
        for (kind, _), shape in zip(self.of_kinds, self.shapes, strict=True):
            size = np.abs(shape.max(axis=1) - shape.min(axis=1)).max(axis=1)
            corners = CORNERS[kind]
            for side, (a, b) in enumerate(EDGES[KINDS[kind]]):
                off = shape[:, corners + side] - 0.5 * (shape[:, a] + shape[:, b])
                if np.any(np.abs(off).max(axis=1) > 1e-9 * size):
                    return True
        return False

    @cached_property
    def edge_table(self) -> tuple[IntArray, IntArray, IntArray]:
        """Edges of all cells: cell, first and second corner in counter-clockwise order, (e,)."""
        cells, ends = [], []
        for kind, rows in self.of_kinds:
            edges = EDGES[KINDS[kind]]
            cells.append(np.repeat(rows, len(edges)))
            ends.append(self.nodes[rows][:, edges].reshape(-1, 2))
        first, second = np.concatenate(ends).T
        return np.concatenate(cells), first, second

    @cached_property
    def middles(self) -> Array:
        """Mean of the corners of each cell, (c, 2) [m]."""
        out = np.empty((self.n_cell, 2))
        for kind, rows in self.of_kinds:
            out[rows] = self.points[self.nodes[rows, : CORNERS[kind]]].mean(axis=1)
        return out

    def region_points(self, cells: IntArray) -> Array:
        """Positions of all nodes of some cells, (n, 2) [m]."""
        chosen = np.zeros(self.n_cell, dtype=bool)
        chosen[cells] = True
        parts = [
            shape[chosen[rows]].reshape(-1, 2)
            for (_, rows), shape in zip(self.of_kinds, self.shapes, strict=True)
        ]
        return np.unique(np.concatenate(parts), axis=0)


def cells_of_plain(plain: PlainMesh) -> CellMesh:
    """The mesh that gmsh or a file gave, of one kind of cells or with corners only."""
    c, k = plain.cells.shape
    nodes = np.full((c, MOST_NODES), ABSENT)
    nodes[:, :k] = plain.cells
    if plain.cell in KINDS:
        kind = np.full(c, KINDS.index(plain.cell))
    else:
        kind = (plain.cells[:, 3] != ABSENT).astype(np.int64)
    return CellMesh(plain.points, nodes, kind, plain.region, plain.regions)


def turned(mesh: CellMesh) -> CellMesh:
    """The same section; quadrilaterals are numbered from their opposite corner."""
    nodes = mesh.nodes.copy()
    rows = mesh.kind == KINDS.index("quadrilateral")
    nodes[rows] = mesh.nodes[rows][:, OPPOSITE]
    angles = mesh.layer_angle
    if angles is not None and angles.shape[1] > 1:
        angles = angles.copy()
        angles[rows] = angles[rows][:, OPPOSITE]
    return replace(mesh, nodes=nodes, layer_angle=angles)


def within(rows: IntArray, some: slice) -> NDArray[np.bool_]:
    """Which rows (c,) are in a slice."""
    return (rows >= some.start) & (rows < some.stop)


def patterns(nodes: IntArray) -> list[tuple[IntArray, IntArray]]:
    """Groups of cells with the same nodes present: the local nodes, and the rows of the cells."""
    present = nodes >= 0
    unique, group = np.unique(present, axis=0, return_inverse=True)
    group = group.ravel()
    return [(np.flatnonzero(row), np.flatnonzero(group == i)) for i, row in enumerate(unique)]


def filling(kind: int, pattern: IntArray) -> Array:
    """Values at all 6 or 9 nodes from those at the nodes present, (6 or 9, present).

    An absent middle of an edge has the mean of its ends. An absent centre has the value that the
    functions of the eight-node quadrilateral give it.
    """
    corners, full = CORNERS[kind], FULL[kind]
    out = np.zeros((full, full))
    out[pattern, pattern] = 1.0
    for edge, (a, b) in enumerate(EDGES[KINDS[kind]]):
        if corners + edge not in pattern:
            out[corners + edge] = 0.5 * (out[a] + out[b])
    if full == 9 and 8 not in pattern:
        out[8] = 0.5 * out[4:8].sum(axis=0) - 0.25 * out[:4].sum(axis=0)
    return out[:, pattern]


def full_basis(kind: int, points: Array) -> tuple[Array, Array]:
    """Functions of all 6 or 9 nodes at points of the reference cell, in the order of the nodes.

    Values (q, 6 or 9) and slopes (q, 6 or 9, 2).
    """
    values, slopes = fenicsx.lagrange(KINDS[kind], 2, points)
    order = fenicsx.order_of_nodes(KINDS[kind])
    return values[:, order], slopes[:, order]


Edge = tuple[int, int]

# Places of the nodes on the reference cell whose corners children have, and these corners: corners
# of the parent, middles of its edges, centre.
PLACES = (NODES["triangle"] / 2.0, NODES["quadrilateral"] / 2.0)
CHILDREN = (
    np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]),
    np.array([[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]]),
)


def refined(mesh: CellMesh, marked: NDArray[np.bool_]) -> CellMesh:
    """The mesh with the marked cells (c,) divided into four, and as many others as this requires.

    The map of the parent gives new nodes, so that the shape does not change. Cells on both sides of
    an edge differ by one division at most.
    """
    marked = _with_neighbours(mesh, marked)
    work = _Division(mesh, marked)
    return work.divided()


def _key(a: int, b: int) -> Edge:
    return (int(a), int(b)) if a < b else (int(b), int(a))


def _with_neighbours(mesh: CellMesh, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells with an edge on which a marked cell hangs are marked too."""
    if not len(mesh.hanging):
        return marked
    half = {}
    for a, b, m in mesh.hanging.tolist():
        half[_key(a, m)] = half[_key(m, b)] = _key(a, b)
    owner: dict[Edge, int] = {}
    cells, first, second = mesh.edge_table
    whole = set(half.values())
    for cell, a, b in zip(cells.tolist(), first.tolist(), second.tolist(), strict=True):
        if _key(a, b) in whole:
            owner[_key(a, b)] = cell
    marked = marked.copy()
    waiting = np.flatnonzero(marked).tolist()
    while waiting:
        cell = waiting.pop()
        corners = mesh.nodes[cell]
        for edge in (_key(corners[a], corners[b]) for a, b in EDGES[KINDS[mesh.kind[cell]]]):
            other = owner.get(half.get(edge, (-1, -1)), -1)
            if other >= 0 and not marked[other]:
                marked[other] = True
                waiting.append(other)
    return marked


class _Division:
    """New points and cells of one refinement."""

    def __init__(self, mesh: CellMesh, marked: NDArray[np.bool_]) -> None:
        self.mesh, self.marked = mesh, marked
        self.linear = mesh.degree == 1
        self.points: list[Array] = []
        self.n = len(mesh.points)
        self.middle: dict[Edge, int] = {}  # node in the middle of an edge
        for kind, rows in mesh.of_kinds:
            corners = CORNERS[kind]
            for side, (a, b) in enumerate(EDGES[KINDS[kind]]):
                nodes = mesh.nodes[rows]
                known = nodes[:, corners + side] >= 0
                for p, q, m in nodes[known][:, [a, b, corners + side]].tolist():
                    self.middle[_key(p, q)] = m
        for a, b, m in mesh.hanging.tolist():
            self.middle[_key(a, b)] = m
        self.split: dict[Edge, int] = {_key(a, b): m for a, b, m in mesh.hanging.tolist()}

    def divided(self) -> CellMesh:
        mesh = self.mesh
        nodes, kinds, regions, angles = [], [], [], []
        for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
            chosen = self.marked[rows]
            cells = rows[chosen]
            if not len(cells):
                continue
            nodes.append(self._children(kind, cells, shape[chosen]))
            kinds.append(np.full(4 * len(cells), kind))
            regions.append(np.repeat(mesh.region[cells], 4))
            if mesh.layer_angle is not None:
                angles.append(self._angles(kind, mesh.layer_angle[cells]))
        kept = ~self.marked
        new = CellMesh(
            np.concatenate([mesh.points, *self.points]),
            np.concatenate([mesh.nodes[kept], *nodes]),
            np.concatenate([mesh.kind[kept], *kinds]),
            np.concatenate([mesh.region[kept], *regions]),
            mesh.regions,
            layer_angle=None
            if mesh.layer_angle is None
            else np.concatenate([mesh.layer_angle[kept], *angles]),
        )
        _, first, second = new.edge_table
        left = {_key(a, b) for a, b in zip(first.tolist(), second.tolist(), strict=True)}
        hanging = [(*edge, m) for edge, m in self.split.items() if edge in left]
        return replace(new, hanging=np.array(hanging, dtype=np.int64).reshape(-1, 3))

    def _node(self, place: Array) -> int:
        self.points.append(place[None])
        self.n += 1
        return self.n - 1

    def _middle(self, a: int, b: int, place: Array) -> int:
        edge = _key(a, b)
        if edge not in self.middle:
            self.middle[edge] = self._node(place)
        return self.middle[edge]

    def _children(self, kind: int, cells: IntArray, shape: Array) -> IntArray:
        corners, full = CORNERS[kind], FULL[kind]
        edges = EDGES[KINDS[kind]]
        reference = _child_places(kind)  # (4, full, 2)
        places = (full_basis(kind, reference.reshape(-1, 2))[0] @ shape).reshape(
            len(cells), 4, full, 2
        )
        whole = full_basis(kind, PLACES[kind])[0] @ shape
        out = np.full((len(cells), 4, MOST_NODES), ABSENT)
        for i, cell in enumerate(cells.tolist()):
            parent = self.mesh.nodes[cell]
            local = np.full(full, ABSENT)
            local[:corners] = parent[:corners]
            for side, (a, b) in enumerate(edges):
                m = self._middle(parent[a], parent[b], whole[i, corners + side])
                self.split[_key(parent[a], parent[b])] = m
                local[corners + side] = m
            if full == 9:
                local[8] = parent[8] if parent[8] >= 0 else self._node(whole[i, 8])
            for j, child in enumerate(CHILDREN[kind]):
                own = local[child]
                out[i, j, :corners] = own
                if self.linear:
                    continue
                for side, (a, b) in enumerate(edges):
                    out[i, j, corners + side] = self._middle(
                        own[a], own[b], places[i, j, corners + side]
                    )
                if full == 9:
                    out[i, j, 8] = self._node(places[i, j, 8])
        return out.reshape(-1, MOST_NODES)

    @staticmethod
    def _angles(kind: int, angles: Array) -> Array:
        """Layer angles of the children: those of the parent at their nodes."""
        if angles.shape[1] == 1:
            return np.repeat(angles, 4, axis=0)
        full = FULL[kind]
        values = full_basis(kind, _child_places(kind).reshape(-1, 2))[0] @ angles[:, :full, None]
        out = np.zeros((len(angles) * 4, MOST_NODES))
        out[:, :full] = values.reshape(-1, full)
        return out


def _child_places(kind: int) -> Array:
    """Positions of all nodes of the children on the reference cell, (4, 6 or 9, 2)."""
    out = []
    for child in CHILDREN[kind]:
        corners = PLACES[kind][child]
        middles = [0.5 * (corners[a] + corners[b]) for a, b in EDGES[KINDS[kind]]]
        centre = [corners.mean(axis=0)] if FULL[kind] == 9 else []
        out.append(np.array([*corners, *middles, *centre]))
    return np.array(out)
