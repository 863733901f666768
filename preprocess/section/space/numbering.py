"""Functions of the cells of a section: numbers of their nodes, parts of equal cells, sparsity.

Of the nodes of continuous Lagrange functions, corners come first, then the nodes inside edges, then
those inside cells.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from ufl import JacobianDeterminant, SpatialCoordinate, as_vector

from ....solver.math.arrays import Array
from ... import fenicsx
from ...fenicsx import EDGES, NODES
from .section_cells import CORNERS, FULL, KINDS, CellMesh, IntArray, filling, full_basis, patterns

NEAR = 1e-9  # of the reference cell


class Numbering:
    """Nodes of each cell, and the values of nodes that neighbours determine.

    Attributes
    ----------
    n_node : number of nodes
    of_cells : for each kind in mesh.of_kinds, (c, k) nodes in the order of Basix
    """

    def __init__(self, mesh: CellMesh, degree: int) -> None:
        self.degree = degree
        self._vertex, compact = np.unique(
            np.concatenate([mesh.edge_table[1], mesh.edge_table[2], mesh.hanging.ravel()]),
            return_inverse=True,
        )
        e = len(mesh.edge_table[0])
        first, second = compact[:e], compact[e : 2 * e]
        self._hanging = compact[2 * e :].reshape(-1, 3)
        n_vertex = len(self._vertex)
        low, high = np.minimum(first, second), np.maximum(first, second)
        self._keys, edge = np.unique(low * n_vertex + high, return_inverse=True)
        self._n_vertex, n_edge = n_vertex, len(self._keys)
        inner = degree - 1  # nodes inside an edge
        total = n_vertex + n_edge * inner
        self.of_cells: list[IntArray] = []
        start = 0
        for kind, rows in mesh.of_kinds:
            sides = CORNERS[kind]
            some = slice(start, start + len(rows) * sides)
            start = some.stop
            corner = first[some].reshape(-1, sides)
            forward = (first < second)[some].reshape(-1, sides)
            edges = edge[some].reshape(-1, sides)
            places = fenicsx.reference_nodes(KINDS[kind], degree)
            nodes = np.full((len(rows), len(places)), -1)
            inside = []
            for local, place in enumerate(places):
                vertex, side, t = _where(kind, place)
                if vertex >= 0:
                    nodes[:, local] = corner[:, vertex]
                elif side >= 0:
                    row = int(np.argmin(np.abs(_inner(degree) - t)))
                    step = np.where(forward[:, side], row, inner - 1 - row)
                    nodes[:, local] = n_vertex + edges[:, side] * inner + step
                else:
                    inside.append(local)
            count = len(inside)
            own = total + np.arange(len(rows) * count).reshape(len(rows), count)
            nodes[:, inside] = own
            total += own.size
            self.of_cells.append(nodes)
        self.n_node = total

    def expansion(self) -> sp.csr_matrix | None:
        """Values of all nodes from the free ones, (n_node, n_free); None without hanging nodes.

        The values of nodes on half an edge follow from those of the whole edge.
        """
        if not len(self._hanging):
            return None
        p = self.degree
        inner = _inner(p)
        along = np.argsort(fenicsx.reference_nodes("interval", p)[:, 0])  # Basix: ends first
        matrix = sp.identity(self.n_node, format="lil")
        for a, b, m in self._hanging:
            lo, hi = min(a, b), max(a, b)
            masters = self._edge_nodes(lo, hi)
            rows, places = [int(m)], [0.5]
            for end, at in ((lo, 0.0), (hi, 1.0)):
                nodes = self._edge_nodes(min(end, m), max(end, m))[1:-1]
                # they are numbered from the end with the lower number
                local = at + (0.5 - at) * inner if end < m else 0.5 + (at - 0.5) * inner
                rows += nodes
                places += list(local)
            weights = fenicsx.lagrange("interval", p, np.array(places)[:, None])[0][:, along]
            for row, values in zip(rows, weights, strict=True):
                matrix.rows[row], matrix.data[row] = [], []
                for column, value in sorted(zip(masters, values, strict=True)):
                    if abs(value) > 1e-14:
                        matrix.rows[row].append(column)
                        matrix.data[row].append(float(value))
        P = matrix.tocsr()
        slaves = np.flatnonzero(np.asarray(P.diagonal()) == 0.0)
        while True:  # a master may be a slave of a still larger cell
            free = np.ones(self.n_node, dtype=bool)
            free[slaves] = False
            if not P[:, ~free].nnz:
                return P[:, free].tocsr()
            P = (P @ P).tocsr()

    def _edge_nodes(self, low: int, high: int) -> list[int]:
        """Nodes of an edge from its lower to its higher corner."""
        edge = int(np.searchsorted(self._keys, low * self._n_vertex + high))
        assert self._keys[edge] == low * self._n_vertex + high, "a hanging node without its edge"
        first = self._n_vertex + edge * (self.degree - 1)
        return [int(low), *range(first, first + self.degree - 1), int(high)]


def _where(kind: int, place: Array) -> tuple[int, int, float]:
    """Corner, or edge and position on it, of a node of the reference cell; -1 if neither."""
    corners = NODES[KINDS[kind]][: CORNERS[kind]] / 2.0
    near = np.flatnonzero(np.abs(corners - place).max(axis=1) < NEAR)
    if near.size:
        return int(near[0]), -1, 0.0
    for side, (a, b) in enumerate(EDGES[KINDS[kind]]):
        along, away = corners[b] - corners[a], place - corners[a]
        if abs(along[0] * away[1] - along[1] * away[0]) < NEAR:
            return -1, side, float(along @ away / (along @ along))
    return -1, -1, 0.0


def _inner(degree: int) -> Array:
    """Positions of the nodes inside an edge of length 1, ascending."""
    return np.asarray(np.sort(fenicsx.reference_nodes("interval", degree)[:, 0])[1:-1])


EVERY = slice(None)


def with_slopes(_domain: Any, u: Any, _k: Any) -> Any:
    """u, u,2 and u,3 of the functions u of a cell."""
    return as_vector([u, u.dx(0), u.dx(1)])


def position(domain: Any, _u: Any, _k: Any) -> Any:
    """x2, x3 and the determinant of the map."""
    x = SpatialCoordinate(domain)
    return as_vector([x[0], x[1], JacobianDeterminant(domain)])


@dataclass(frozen=True)
class CellBlock:
    """Some cells of one kind with the same functions; `c` counts them, `k` their nodes."""

    kind: int
    rows: IntArray  # (c,) of the mesh
    shape: Array  # (c, 6 or 9, 2) positions of the nodes of the map [m]
    nodes: IntArray  # (c, k) nodes of the functions
    degree: int | None  # of Lagrange functions, None: those of `filling`
    filling: Array | None  # (6 or 9, k)

    @property
    def is_linear(self) -> bool:
        """True if the functions are those of corners only."""
        return self.nodes.shape[1] == CORNERS[self.kind]

    def functions(self, points: Array, some: IntArray) -> Array:
        """The functions u with u,2 and u,3 of some cells at points of the reference cell,
        (c, q, 3, k)."""
        values = self.evaluated(with_slopes, points, some)
        # A translation has no strain. The rounding of compiled tables is the same in all cells, so
        # that it would add up: very thin strips lose half a digit by it.
        values[:, :, 1:] -= values[:, :, :1] * values[:, :, 1:].sum(axis=-1, keepdims=True)
        if self.filling is None:
            return values
        return np.asarray(values[..., fenicsx.order_of_nodes(KINDS[self.kind])] @ self.filling)

    def map(self, points: Array, some: IntArray) -> Array:
        """Positions x2, x3 and determinant of the map of some cells at points, (c, q, 3)."""
        return self.evaluated(position, points, some)

    def values(self, points: Array) -> Array:
        """The functions at points of the reference cell, (q, k)."""
        if self.filling is not None:
            return np.asarray(full_basis(self.kind, points)[0] @ self.filling)
        assert self.degree is not None
        return fenicsx.lagrange(KINDS[self.kind], self.degree, points)[0]

    def evaluated(
        self, text: Any, points: Array, some: IntArray | slice = EVERY, k: Array | None = None
    ) -> Array:
        """`fenicsx.evaluated` for some of the cells, with constants k."""
        return fenicsx.evaluated(
            text, KINDS[self.kind], self.degree or 2, points, self.shape[some], k
        )

    def places(self) -> Array:
        """Positions of the nodes of the functions, (c, k, 2) [m]."""
        if self.degree is None:
            assert self.filling is not None
            present = np.flatnonzero(self.filling.max(axis=1) == 1.0)
            return self.shape[:, present]
        reference = fenicsx.reference_nodes(KINDS[self.kind], self.degree)
        return np.asarray(full_basis(self.kind, reference)[0] @ self.shape)


def lagrange_parts(
    mesh: CellMesh, degree: int
) -> tuple[list[CellBlock], int, sp.csr_matrix | None]:
    """Lagrange functions: the parts, the number of nodes, and `Numbering.expansion`."""
    numbering = Numbering(mesh, degree)
    parts = [
        CellBlock(kind, rows, shape, nodes, degree, None)
        for (kind, rows), shape, nodes in zip(
            mesh.of_kinds, mesh.shapes, numbering.of_cells, strict=True
        )
    ]
    return parts, numbering.n_node, numbering.expansion()


def own_parts(mesh: CellMesh) -> tuple[list[CellBlock], int]:
    """The functions of the nodes that each cell has: the parts and the number of nodes."""
    used, compact = np.unique(mesh.nodes, return_inverse=True)
    absent = int(used[0] < 0)
    table = compact.reshape(mesh.nodes.shape) - absent
    parts = []
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        nodes = table[rows, : FULL[kind]]
        for pattern, of in patterns(nodes):
            fill = filling(kind, pattern)
            parts.append(CellBlock(kind, rows[of], shape[of], nodes[of][:, pattern], None, fill))
    return parts, len(used) - absent


IntTable = NDArray[np.int32]


class Pattern:
    """The pattern of matrices with 3x3 blocks for every pair of nodes that share a cell.

    Parameters
    ----------
    dofs : (n_cell, k) nodes of the cells
    n_node : number of nodes

    Unknowns are numbered node by node, three to a node.
    """

    def __init__(self, dofs: IntTable, n_node: int) -> None:
        k = dofs.shape[1]
        self.n_dof = 3 * n_node
        self._k = k
        count = dofs.size * k
        # SciPy's conversions between rows and columns sort the entries of all cells by pairs, in a
        # quarter of the time of np.unique
        entry, ends = np.arange(count, dtype=np.int32), np.arange(0, count + 1, k, dtype=np.int32)
        by_column = sp.csr_matrix(
            (entry, np.tile(dofs, (1, k)).ravel(), ends), shape=(dofs.size, n_node)
        ).tocsc()
        pairs = sp.csc_matrix(
            (by_column.data, dofs.ravel()[by_column.indices], by_column.indptr),
            shape=(n_node, n_node),
        ).tocsr()
        row = np.repeat(np.arange(n_node), np.diff(pairs.indptr))
        first = np.flatnonzero(
            np.diff(row, prepend=-1).astype(bool) | np.diff(pairs.indices, prepend=-1).astype(bool)
        )
        self._n_pair = first.size
        # (n_pair, n_cell k^2): sums the entries of the cells for the same pair
        self._sum = sp.csr_matrix(
            (np.ones(count), pairs.data, np.append(first, count).astype(np.int32)),
            shape=(first.size, count),
        )
        # SciPy's conversion from blocks to rows gives the position of each entry
        start = np.searchsorted(row[first], np.arange(n_node + 1)).astype(np.int32)
        number = np.arange(9 * first.size, dtype=np.int32).reshape(-1, 3, 3)
        blocks = sp.bsr_matrix(
            (number, pairs.indices[first], start), shape=(self.n_dof, self.n_dof)
        )
        whole = blocks.tocsr()
        self._order = whole.data.astype(np.intp)
        self.indptr, self.indices = whole.indptr, whole.indices

    def data(self, blocks: Array) -> Array:
        """Values of the matrix, (nnz,): the sum of the blocks (c, k^2, 9) of the cells.

        The block of nodes i, j of a cell is row k i + j, its entries are 3 a + b.
        """
        return self.ordered(self._sum @ blocks.reshape(-1, 9))

    def ordered(self, blocks: Array) -> Array:
        """Values of the matrix, (nnz,), from the blocks (n_pair, 9) of all pairs of nodes."""
        return np.take(blocks.ravel(), self._order)

    def summed(self, factors: Array) -> sp.csr_matrix:
        """Matrix that maps columns (c m, 9) to the sum of `factors @ columns` for all pairs.

        `factors` (c, k^2, m) are those of the cells, which have m rows of columns each.
        """
        entries, m = self._sum, factors.shape[2]
        data = np.take(factors.reshape(-1, m), entries.indices, axis=0).ravel()
        first = m * (entries.indices // self._k**2)
        indices = (first[:, None] + np.arange(m, dtype=first.dtype)).ravel()
        shape = (self._n_pair, factors.shape[0] * m)
        return sp.csr_matrix((data, indices, m * entries.indptr), shape=shape)

    def matrix(self, data: Array) -> sp.csr_matrix:
        """The matrix of values (nnz,)."""
        shape = (self.n_dof, self.n_dof)
        return sp.csr_matrix((data, self.indices, self.indptr), shape=shape)

    def without(self, pins: NDArray[np.int64]) -> "Restriction":
        """The pattern without the rows and columns of pinned unknowns."""
        return Restriction(self, pins)


class Restriction:
    """A pattern without some rows and columns: the remaining values and their positions."""

    def __init__(self, pattern: Pattern, pins: NDArray[np.int64]) -> None:
        self.free = np.ones(pattern.n_dof, dtype=bool)
        self.free[pins] = False
        places = np.arange(pattern.indices.size)
        kept = pattern.matrix(places)[self.free][:, self.free]
        self._kept, self._rest, self._shape = kept.data, (kept.indices, kept.indptr), kept.shape

    def matrix(self, data: Array) -> sp.csr_matrix:
        """The free part of the matrix of values (nnz,)."""
        return sp.csr_matrix((data[self._kept], *self._rest), shape=self._shape)
