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
ROUNDING = 1e-14  # of the functions of an edge


def lagrange_nodes(mesh: CellMesh, degree: int) -> tuple[list[IntArray], int, sp.csr_matrix | None]:
    """Nodes of Lagrange functions; those on an edge are numbered by its corners and their place.

    Returns
    -------
    of_cells : for each kind in mesh.of_kinds, (c, k) nodes in the order of Basix
    n_node : number of nodes
    P : values of all nodes from the free ones, (n_node, n_free), where those on half an edge follow
        from those of the whole edge; None without hanging nodes
    """
    along = fenicsx.reference_nodes("interval", degree)[:, 0]
    order = np.argsort(along)  # Basix: ends first
    along = along[order]

    def key(a: IntArray, b: IntArray, step: Any) -> IntArray:
        """A number for the node after some steps on the edge from corner a to corner b."""
        low, high = np.minimum(a, b), np.maximum(a, b)
        step = np.where(a < b, step, degree - step)
        n = len(mesh.points)
        # after all corners: thin walls then have their base on the same face everywhere
        # (unknowns.py)
        inside = n + (low * n + high) * degree + step
        return np.where(step == 0, low, np.where(step == degree, high, inside))

    tables = []
    for kind, rows in mesh.of_kinds:
        corners = mesh.nodes[rows, : CORNERS[kind]]
        places = fenicsx.reference_nodes(KINDS[kind], degree)
        tables.append(np.full((len(rows), len(places)), -1))
        for local, place in enumerate(places):
            for a, b, step in _on_edge(kind, place, along):
                tables[-1][:, local] = key(corners[:, a], corners[:, b], step)
    keys = np.unique(np.concatenate([table.ravel() for table in tables]))
    keys = keys[keys >= 0]
    of_cells, total = [], len(keys)
    for table in tables:
        nodes, inside = np.searchsorted(keys, table), table < 0
        count = int(np.count_nonzero(inside))
        nodes[inside] = total + np.arange(count)
        total += count
        of_cells.append(nodes)
    if not len(mesh.hanging):
        return of_cells, total, None
    a, b, middle = mesh.hanging.T[:, :, None]
    steps = np.arange(degree + 1)
    masters = np.searchsorted(keys, key(a, b, steps))
    halves = [key(a, middle, steps[1:]), key(middle, b, steps[1:-1])]
    slaves = np.searchsorted(keys, np.concatenate(halves, axis=1))
    at = np.concatenate([0.5 * along[1:], 0.5 + 0.5 * along[1:-1]])
    weights = fenicsx.lagrange("interval", degree, at[:, None])[0][:, order]
    weights[np.abs(weights) < ROUNDING] = 0.0
    shape = (len(mesh.hanging), len(at), len(steps))
    entries = [
        np.broadcast_to(part, shape).ravel()
        for part in (weights, slaves[:, :, None], masters[:, None])
    ]
    free = np.ones(total, dtype=bool)
    free[slaves] = False
    of_slaves = sp.csr_matrix((entries[0], (entries[1], entries[2])), shape=(total, total))
    of_slaves.eliminate_zeros()
    P = sp.csr_matrix(sp.diags(free.astype(float)) + of_slaves)
    while P[:, ~free].nnz:  # a master may be a slave of a still larger cell
        P = P @ P
    return of_cells, total, P[:, free].tocsr()


def _on_edge(kind: int, place: Array, along: Array) -> list[tuple[int, int, int]]:
    """Corners of an edge of the reference cell that has a node, and its steps from the first one.

    No edge: empty. `along` are the places of nodes on an edge of length 1.
    """
    corners = NODES[KINDS[kind]][: CORNERS[kind]] / 2.0
    for a, b in EDGES[KINDS[kind]]:
        edge, away = corners[b] - corners[a], place - corners[a]
        if abs(edge[0] * away[1] - edge[1] * away[0]) < NEAR:
            return [(a, b, int(np.argmin(np.abs(along - edge @ away / (edge @ edge)))))]
    return []


EVERY = slice(None)


def _with_slopes(_domain: Any, u: Any, _k: Any) -> Any:
    """u, u,2 and u,3 of the functions u of a cell."""
    return as_vector([u, u.dx(0), u.dx(1)])


def _position(domain: Any, _u: Any, _k: Any) -> Any:
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
        values = self.evaluated(_with_slopes, points, some)
        # A translation has no strain. The rounding of compiled tables is the same in all cells, so
        # that it would add up: very thin strips lose half a digit by it.
        values[:, :, 1:] -= values[:, :, :1] * values[:, :, 1:].sum(axis=-1, keepdims=True)
        if self.filling is None:
            return values
        return np.asarray(values[..., fenicsx.order_of_nodes(KINDS[self.kind])] @ self.filling)

    def map(self, points: Array, some: IntArray) -> Array:
        """Positions x2, x3 and determinant of the map of some cells at points, (c, q, 3)."""
        return self.evaluated(_position, points, some)

    def values(self, points: Array) -> Array:
        """The functions at points of the reference cell, (q, k)."""
        if self.filling is not None:
            return np.asarray(full_basis(self.kind, points)[0] @ self.filling)
        assert self.degree is not None
        return fenicsx.lagrange(KINDS[self.kind], self.degree, points)[0]

    def evaluated(
        self, text: Any, points: Array, some: IntArray | slice = EVERY, k: Array | None = None
    ) -> Array:
        """`fenicsx.evaluated` for some of the cells.

        Parameters
        ----------
        text : in UFL, as of `fenicsx.evaluated`
        points : (q, 2) of the reference cell
        some : rows of the block
        k : (n,) constants of the text
        """
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
    """Lagrange functions: the parts, the number of nodes, and P of `lagrange_nodes`."""
    of_cells, n_node, P = lagrange_nodes(mesh, degree)
    parts = [
        CellBlock(kind, rows, shape, nodes, degree, None)
        for (kind, rows), shape, nodes in zip(mesh.of_kinds, mesh.shapes, of_cells, strict=True)
    ]
    return parts, n_node, P


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
        self._k, self.n_dof = dofs.shape[1], 3 * n_node
        # the pair of nodes of each entry of the cells, as row n + column
        pairs = (dofs[:, :, None].astype(np.int64) * n_node + dofs[:, None]).ravel()
        order = np.argsort(pairs, kind="stable")
        first = np.flatnonzero(np.diff(pairs[order], prepend=-1))
        row, column = np.divmod(pairs[order[first]], n_node)
        self._n_pair, count = len(first), len(pairs)
        # (n_pair, n_cell k^2): sums the entries of the cells for the same pair
        self._sum = sp.csr_matrix(
            (np.ones(count), order, np.append(first, count)), shape=(self._n_pair, count)
        )
        # SciPy's conversion from blocks to rows gives the position of each entry
        start = np.searchsorted(row, np.arange(n_node + 1))
        number = np.arange(9 * self._n_pair, dtype=np.int32).reshape(-1, 3, 3)
        whole = sp.bsr_matrix((number, column, start), shape=(self.n_dof, self.n_dof)).tocsr()
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
