"""Matrices that the processes of a team have in parts: each has the matrix of its own cells.

The matrix of a problem is the sum of the parts, which are (n, n) each. Products are sums over the
team; for a factorisation, every process gets rows of the sum.
"""

from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp

from .stack import Array, PETSc
from .team import Team


class Distribution:
    """Which process has which rows of a sum of parts.

    A row goes to the first process whose part has entries in it, so that rows between the cells
    of two processes are all that is sent. A process alone has all rows, in their order.

    Parameters
    ----------
    parts : (n, n) of this process, of the matrices of one problem
    """

    def __init__(self, team: Team, *parts: sp.csr_matrix) -> None:
        self.team, self.n = team, parts[0].shape[0]
        self.rows: Any = slice(0, self.n)  # of this process
        self.n_own = self.n
        if team.size == 1:
            return
        filled = np.logical_or.reduce([np.diff(part.indptr) > 0 for part in parts])
        owner = team.least(np.where(filled, team.rank, team.size - 1))
        group = 2 * owner + (team.total(filled.astype(float)) > 1.0)
        # PETSc's order: process by process, of each the rows that others have entries in at the end
        self._order = np.argsort(group, kind="stable")
        bounds = np.searchsorted(group[self._order], np.arange(2 * team.size + 1))
        groups = [self._order[a:b] for a, b in pairwise(bounds)]
        self._inner, self._shared = groups[2 * team.rank], groups[1::2]
        self.rows = np.concatenate([self._inner, self._shared[team.rank]])
        self.n_own = len(self.rows)
        self._number = np.empty(self.n, dtype=PETSc.IntType)
        self._number[self._order] = np.arange(self.n)

    @property
    def size(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Rows and columns of a matrix, of this process and of all, for PETSc."""
        return (self.n_own, self.n), (self.n_own, self.n)

    def csr(self, part: sp.csr_matrix) -> tuple[Any, Any, Array]:
        """Own rows of the sum of parts, for PETSc: starts, columns, values."""
        index = PETSc.IntType
        if self.team.size > 1:
            mine = self.team.rank
            pieces = [None if i == mine else part[rows] for i, rows in enumerate(self._shared)]
            inner, shared = part[self._inner], part[self._shared[mine]]
            for piece in self.team.comm.alltoall(pieces):
                if piece is not None:
                    shared = shared + piece
            starts = np.concatenate([inner.indptr, inner.indptr[-1] + shared.indptr[1:]])
            columns = self._number[np.concatenate([inner.indices, shared.indices])]
            return starts.astype(index), columns, np.concatenate([inner.data, shared.data])
        return (
            part.indptr.astype(index, copy=False),
            part.indices.astype(index, copy=False),
            part.data,
        )

    def matrix(self, part: sp.csr_matrix, *, spd: bool) -> Any:
        """The sum of parts as a symmetric matrix of PETSc, which may be positive definite."""
        # PETSc makes a copy only for a team: for a process alone, new values need no insertion
        create = "createAIJ" if self.team.size > 1 else "createAIJWithArrays"
        mat = getattr(PETSc.Mat(), create)(self.size, csr=self.csr(part), comm=self.team.comm)
        mat.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        if spd:
            mat.setOption(PETSc.Mat.Option.SPD, True)  # MUMPS then runs with SYM=1, half an LU
        return mat

    def gathered(self, own: Array) -> Array:
        """Rows of a vector or several (n, ...) on all processes, from the own ones of each."""
        if self.team.size == 1:
            return own
        stacked = self.team.stacked(own)
        out = np.empty_like(stacked)
        out[self._order] = stacked
        return out


def whole(part: sp.csr_matrix, team: Team) -> sp.csr_matrix:
    """The sum of the parts of a small matrix, on all processes."""
    return part if team.size == 1 else sp.csr_matrix(team.total(part.toarray()))
