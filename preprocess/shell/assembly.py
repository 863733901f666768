"""Assembly of sparse matrices of the shell; the pattern is computed once.

Six unknowns per node, in the node numbering of the mesh. Element matrices are divided into
blocks of two nodes. One sparse matrix of zeros and ones sums the blocks of equal nodes.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray

DOFS = 6  # dofs of a node: ux uy uz rx ry rz
NO_LINES = np.zeros((0, 2), dtype=np.int64)
NO_MATRICES = np.zeros((0, 12, 12))


class Assembly:
    """The sparsity pattern of a mesh.

    Parameters
    ----------
    cells : tables of nodes, (c, 3) or (c, 4), in the order in which element matrices will come
    n_node : number of nodes; a node without cells gets a zero block on the diagonal
    extra : nodes appended for the reference points of links, also with zero blocks
    lines : (l, 2) nodes of the beams that stiffen it
    """

    def __init__(
        self, cells: Sequence[IntArray], n_node: int, extra: int = 0, lines: IntArray = NO_LINES
    ) -> None:
        n = n_node + extra
        pairs = [(c[:, :, None] * n + c[:, None, :]).ravel() for c in (*cells, lines)]
        pair = np.concatenate(pairs)
        alone = np.arange(n) * (n + 1)
        key, number = np.unique(np.concatenate([pair, alone]), return_inverse=True)
        number = number.ravel()[: len(pair)]
        self.n_dof = DOFS * n
        self._rows, self._columns = np.divmod(key, n)
        starts = np.concatenate([[0], np.cumsum(np.bincount(self._rows, minlength=n))])
        ones = np.ones(len(pair))
        self._sum = sp.csr_matrix(
            (ones, (number, np.arange(len(pair)))), shape=(len(key), len(pair))
        )
        # order of the entries of the blocks (b, 6, 6) in compressed rows, block row by block row
        count = np.diff(starts)
        self.indptr = np.concatenate([[0], np.cumsum(np.repeat(DOFS * count, DOFS))])
        self._order, self.indices = self._entries(starts, count)
        if len(self.indices) < np.iinfo(np.int32).max:  # PETSc uses this type without a copy
            self.indptr = self.indptr.astype(np.int32)
            self.indices = self.indices.astype(np.int32)

    def matrix(self, elements: Sequence[Array], line: Array = NO_MATRICES) -> sp.csr_matrix:
        """Sum of element matrices (c, 18|24, 18|24) of cells and (l, 12, 12) of lines, as
        compressed rows with ascending columns. Paper: Eq. (24).
        """
        parts = [_pairs(element, element.shape[1] // DOFS) for element in elements]
        if len(line):
            parts.append(_pairs(line, 2))
        pairs = parts[0] if len(parts) == 1 else np.concatenate(parts)
        blocks = self._sum @ pairs
        data = blocks.ravel()[self._order]
        return sp.csr_matrix((data, self.indices, self.indptr), shape=(self.n_dof, self.n_dof))

    def _entries(self, starts: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
        """Position in the blocks, and column, of each entry of the compressed rows."""
        block = np.arange(len(self._columns))
        within = np.arange(DOFS)
        # entry (i, j) of block b of block row r is in row 6 r + i at 6 (b - starts[r]) + j
        row = self._rows
        place = (
            self.indptr[DOFS * row][:, None, None]
            + (DOFS * count[row])[:, None, None] * within[:, None]
            + DOFS * (block - starts[row])[:, None, None]
            + within
        )
        order = np.empty(place.size, dtype=np.int64)
        order[place.ravel()] = np.arange(place.size)
        columns = np.empty(place.size, dtype=np.int64)
        wide = np.broadcast_to((DOFS * self._columns)[:, None, None] + within, place.shape)
        columns[place.ravel()] = wide.ravel()
        return order, columns


def _pairs(element: Array, k: int) -> Array:
    """Element matrices (c, 6 k, 6 k) as blocks of two nodes, (c k k, 36)."""
    c = len(element)
    pairs = element.reshape(c, k, DOFS, k, DOFS).transpose(0, 1, 3, 2, 4)
    return np.ascontiguousarray(pairs).reshape(k * k * c, DOFS * DOFS)
