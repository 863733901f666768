"""Cells of a section: triangles and quadrilaterals of 3 to 9 nodes, mixed in one mesh; refinement.

A refined cell is divided into four. Corners of small cells may hang on edges of large ones.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

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
    return renumbered(mesh, mesh.kind == KINDS.index("quadrilateral"), ([], OPPOSITE))


def renumbered(
    mesh: CellMesh, marked: NDArray[np.bool_], orders: Sequence[Sequence[int]]
) -> CellMesh:
    """Return the mesh with the nodes of some cells in another order.

    Parameters
    ----------
    mesh : cells and their nodes
    marked : (c,) cells that are changed
    orders : for each kind of cells, the new order of the nodes of a cell
    """
    nodes, angles = mesh.nodes.copy(), mesh.layer_angle
    tables: list[Any] = [nodes]
    if angles is not None and angles.shape[1] > 1:
        angles = angles.copy()
        tables.append(angles)
    for kind, rows in mesh.of_kinds:
        some = rows[marked[rows]]
        for table in tables if len(some) else ():
            table[some] = table[some][:, orders[kind]]
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


# Corners of the children of a cell: corners of the parent, middles of its edges, its centre.
CHILDREN = (
    np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]),
    np.array([[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]]),
)
STEP = 2**31  # above every number of a node


def refined(mesh: CellMesh, marked: NDArray[np.bool_]) -> CellMesh:
    """The mesh with the marked cells (c,) divided into four, and as many others as this requires.

    The map of the parent gives new nodes, so that the shape does not change. Cells on both sides of
    an edge differ by one division at most.
    """
    marked = _with_neighbours(mesh, marked)
    if not marked.any():
        return mesh
    nodes = _Nodes(mesh)
    divided = [
        (kind, rows[marked[rows]], shape[marked[rows]])
        for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True)
    ]
    tables = [mesh.nodes[rows] for _, rows, _ in divided]
    of_kinds = [(kind, shape) for kind, _, shape in divided]
    parents = nodes.completed(tables, of_kinds)
    children = []
    for table, (kind, _) in zip(parents, of_kinds, strict=True):
        corners = table[:, CHILDREN[kind]].reshape(-1, CORNERS[kind])
        rest = MOST_NODES - CORNERS[kind]
        children.append(np.pad(corners, ((0, 0), (0, rest)), constant_values=ABSENT))
    if mesh.degree == 2:
        places = [(kind, _in_children(kind, shape)) for kind, shape in of_kinds]
        children = nodes.completed(children, places)
    kept = np.flatnonzero(~marked)
    origin = np.concatenate([kept, *(np.repeat(rows, 4) for _, rows, _ in divided)])
    angles = mesh.layer_angle
    if angles is not None:
        of_children = [_angles(kind, angles[rows]) for kind, rows, _ in divided]
        angles = np.concatenate([angles[kept], *of_children])
    new = CellMesh(
        np.concatenate(nodes.points),
        np.concatenate([mesh.nodes[kept], *children]),
        mesh.kind[origin],
        mesh.region[origin],
        mesh.regions,
        layer_angle=angles,
    )
    ends, middle = edges_of(zip([kind for kind, _ in of_kinds], parents, strict=True))
    split = np.concatenate([mesh.hanging, np.column_stack([ends, middle])])
    keys, first = np.unique(_keys(split[:, :2]), return_index=True)
    left = np.isin(keys, _keys(np.column_stack(new.edge_table[1:])))
    return replace(new, hanging=split[first[left]])


def _keys(ends: IntArray) -> IntArray:
    """A number for each pair of nodes (e, 2), whatever their order."""
    return np.asarray(np.sort(ends, axis=1) @ [STEP, 1])


def edges_of(tables: Iterable[tuple[int, IntArray]]) -> tuple[IntArray, IntArray]:
    """Ends (e, 2) of the edges in tables of nodes by kind, and nodes in their middles (e,)."""
    ends, middle = [], []
    for kind, nodes in tables:
        corners = CORNERS[kind]
        ends.append(nodes[:, EDGES[KINDS[kind]]].reshape(-1, 2))
        middle.append(nodes[:, corners : 2 * corners].ravel())
    return np.concatenate(ends), np.concatenate(middle)


def _with_neighbours(mesh: CellMesh, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells with an edge on which a marked cell hangs are marked too."""
    cells, first, second = mesh.edge_table
    keys = _keys(np.column_stack([first, second]))
    order = np.argsort(keys)
    a, b, middle = mesh.hanging.T
    whole, *halves = (
        cells[order[np.searchsorted(keys, _keys(np.column_stack(ends)), sorter=order)]]
        for ends in ((a, b), (a, middle), (middle, b))
    )
    marked = marked.copy()
    while not (settled := marked[whole] | ~(marked[halves[0]] | marked[halves[1]])).all():
        marked[whole[~settled]] = True
    return marked


class _Nodes:
    """Nodes of a mesh whose cells are divided; `points` are those of the mesh and new ones."""

    def __init__(self, mesh: CellMesh) -> None:
        self.points = [mesh.points]
        self._count = len(mesh.points)
        ends, middle = edges_of((kind, mesh.nodes[rows]) for kind, rows in mesh.of_kinds)
        ends = np.concatenate([ends, mesh.hanging[:, :2]])
        middle = np.concatenate([middle, mesh.hanging[:, 2]])
        there = middle >= 0
        self._known, first = np.unique(_keys(ends[there]), return_index=True)
        self._middle = middle[there][first]

    def completed(
        self, tables: Sequence[IntArray], of_kinds: Sequence[tuple[int, Array]]
    ) -> list[IntArray]:
        """Tables of nodes (c, 9) of some kinds, with a node in the middle of each edge and in each
        centre, from the kind and the places (c, 6 or 9, 2) of its nodes."""
        kinds = [kind for kind, _ in of_kinds]
        ends, _ = edges_of(zip(kinds, tables, strict=True))
        places = [x[:, CORNERS[kind] : 2 * CORNERS[kind]].reshape(-1, 2) for kind, x in of_kinds]
        keys, first, number = np.unique(_keys(ends), return_index=True, return_inverse=True)
        node = np.full(len(keys), ABSENT)
        _, own, known = np.intersect1d(keys, self._known, assume_unique=True, return_indices=True)
        node[own] = self._middle[known]
        node[node < 0] = self._added(np.concatenate(places)[first[node < 0]])
        counts = np.cumsum([len(x) for x in places])[:-1]
        out = []
        for table, middle, (kind, x) in zip(
            tables, np.split(node[number.ravel()], counts), of_kinds, strict=True
        ):
            corners, whole = CORNERS[kind], table.copy()
            whole[:, corners : 2 * corners] = middle.reshape(-1, corners)
            if FULL[kind] == MOST_NODES:
                bare = whole[:, 8] < 0
                whole[bare, 8] = self._added(x[bare, 8])
            out.append(whole)
        return out

    def _added(self, places: Array) -> IntArray:
        """Numbers of new nodes at some places (k, 2)."""
        self.points.append(places)
        self._count += len(places)
        return np.arange(self._count - len(places), self._count)


def _in_children(kind: int, values: Array) -> Array:
    """Values at the nodes of children, (4 c, 6 or 9, m), from those of cells (c, 6 or 9, m)."""
    reference = []
    for child in CHILDREN[kind]:
        corners = NODES[KINDS[kind]][child] / 2.0
        middles = [0.5 * (corners[a] + corners[b]) for a, b in EDGES[KINDS[kind]]]
        centre = [corners.mean(axis=0)] if FULL[kind] == MOST_NODES else []
        reference += [*corners, *middles, *centre]
    at = full_basis(kind, np.array(reference))[0] @ values
    return np.asarray(at.reshape(-1, *values.shape[1:]))


def _angles(kind: int, angles: Array) -> Array:
    """Layer angles of the children: those of the parent at their nodes."""
    if angles.shape[1] == 1:
        return np.repeat(angles, 4, axis=0)
    out = np.zeros((len(angles) * 4, MOST_NODES))
    out[:, : FULL[kind]] = _in_children(kind, angles[:, : FULL[kind], None])[..., 0]
    return out
