"""Sparsity pattern of a section, computed once for a mesh, and assembly into it."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ....solver.math.arrays import Array

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
        rows = np.repeat(dofs, k, axis=1).ravel().astype(np.int64)
        columns = np.tile(dofs, (1, k)).ravel()
        pair, entry = np.unique(rows * n_node + columns, return_inverse=True)
        self._n_pair = pair.size
        # (n_pair, n_cell k^2): sums the entries of the cells for the same pair
        self._sum = sp.csr_matrix(
            (np.ones(entry.size), (entry.ravel(), np.arange(entry.size))),
            shape=(pair.size, entry.size),
        )
        # SciPy's conversion from blocks to rows gives the position of each entry
        row, column = np.divmod(pair, n_node)
        start = np.searchsorted(row, np.arange(n_node + 1)).astype(np.int32)
        number = np.arange(9 * pair.size, dtype=np.int32).reshape(-1, 3, 3)
        blocks = sp.bsr_matrix(
            (number, column.astype(np.int32), start), shape=(self.n_dof, self.n_dof)
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
        total = sp.csr_matrix((self._n_pair, factors.shape[0] * m))
        total.data = np.take(factors.reshape(-1, m), entries.indices, axis=0).ravel()
        first = m * (entries.indices // self._k**2)
        total.indices = (first[:, None] + np.arange(m, dtype=first.dtype)).ravel()
        total.indptr = m * entries.indptr
        return total

    def matrix(self, data: Array) -> sp.csr_matrix:
        """The matrix of values (nnz,)."""
        matrix = sp.csr_matrix((self.n_dof, self.n_dof))
        matrix.data, matrix.indices, matrix.indptr = data, self.indices, self.indptr
        matrix.has_sorted_indices = True
        return matrix

    def without(self, pins: NDArray[np.int64]) -> "Restriction":
        """The pattern without the rows and columns of pinned unknowns."""
        return Restriction(self, pins)


class Restriction:
    """A pattern without some rows and columns: the remaining values and their positions."""

    def __init__(self, pattern: Pattern, pins: NDArray[np.int64]) -> None:
        self.free = np.ones(pattern.n_dof, dtype=bool)
        self.free[pins] = False
        number = np.cumsum(self.free, dtype=np.int32) - 1
        self._kept = np.ones(pattern.indices.size, dtype=bool)
        length = np.diff(pattern.indptr)
        # the pattern is symmetric: a pin's column occurs only in the rows named by its row
        rows = [slice(pattern.indptr[pin], pattern.indptr[pin + 1]) for pin in pins]
        for i in np.unique(np.concatenate([pattern.indices[row] for row in rows])):
            row = slice(pattern.indptr[i], pattern.indptr[i + 1])
            self._kept[row] = self.free[pattern.indices[row]]
            length[i] = np.count_nonzero(self._kept[row])
        for row in rows:
            self._kept[row] = False
        self._n = int(np.count_nonzero(self.free))
        self._indices = number[pattern.indices[self._kept]]
        self._indptr = np.concatenate([[0], np.cumsum(length[self.free])]).astype(np.int32)

    def matrix(self, data: Array) -> sp.csr_matrix:
        """The free part of the matrix of values (nnz,)."""
        matrix = sp.csr_matrix((self._n, self._n))
        matrix.data = data[self._kept]
        matrix.indices, matrix.indptr = self._indices, self._indptr
        matrix.has_sorted_indices = True
        return matrix
