"""Cells of a section: triangles and quadrilaterals of 3 to 9 nodes, mixed in one mesh."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....solver.math.arrays import Array
from ... import fenicsx
from ...fenicsx import EDGES, PlainMesh

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
        found = [(kind, np.flatnonzero(self.kind == kind)) for kind in range(len(KINDS))]
        return [(kind, rows) for kind, rows in found if rows.size]

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
