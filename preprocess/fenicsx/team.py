"""Processes that work on one analysis together, and the matrices that each of them has a part of.

Each process has the matrix of its own cells. The matrix of a problem is the sum of the parts, which
are (n, n) each. Products are sums over the team; for a factorisation, every process gets rows of
the sum."""

import sys
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from ..parts import Part
from . import libraries


class Team:
    """Processes that have the same mesh and share its cells and the factorisation.

    Each process has the matrix of its own cells, vectors are whole on all. All results are the same
    on each process; sums over cells, and products with matrices, are summed over the team.

    Parameters
    ----------
    comm : MPI communicator; None: this process alone, which loads MPI when PETSc asks for it
    """

    def __init__(self, comm: Any = None) -> None:
        self._comm = comm
        self.rank = 0 if comm is None else int(comm.rank)
        self.size = 1 if comm is None else int(comm.size)

    @property
    def comm(self) -> Any:
        """The MPI communicator."""
        if self._comm is None:
            self._comm = libraries.MPI.COMM_SELF
        return self._comm

    def share(self, count: int) -> slice:
        """The share of `count` items of this process."""
        return slice(count * self.rank // self.size, count * (self.rank + 1) // self.size)

    def slice_of(self, centres: Array) -> IntArray:
        """The share of cells of this process: a slice across their longest direction."""
        along = np.argsort(centres[:, np.argmax(np.ptp(centres, axis=0))], kind="stable")
        return np.sort(along[self.share(len(centres))])

    def first(self, make: Callable[[], Any]) -> Any:
        """What the first process makes, or the error that it raises, on all processes."""
        if self.size == 1:
            return make()
        made, error = None, None
        if self.rank == 0:
            try:
                made = make()
            except Exception as raised:
                error = raised
        made, error = self.comm.bcast((made, error))
        if error is not None:
            raise error
        return made

    def part(self, own: sp.csr_matrix) -> Any:
        """The matrix of which this process has a part."""
        return own if self.size == 1 else Part(own, self)

    def total(self, part: Array) -> Array:
        """Sum over the team, returned on all processes."""
        if self.size == 1:
            return part
        out = np.empty_like(part)
        self.comm.Allreduce(np.ascontiguousarray(part), out)
        return out

    def least(self, values: IntArray) -> IntArray:
        """The least values over the team, on all processes."""
        self.comm.Allreduce(libraries.MPI.IN_PLACE, values, op=libraries.MPI.MIN)
        return values

    def stacked(self, part: NDArray[Any]) -> NDArray[Any]:
        """Concatenated rows of all processes, returned on all processes."""
        if self.size == 1:
            return part
        rows = self.comm.allgather(len(part))
        out = np.empty((sum(rows), *part.shape[1:]), part.dtype)
        row = out[:1].size  # numbers in a row, that are sent without pickling them
        self.comm.Allgatherv(np.ascontiguousarray(part), [out, [n * row for n in rows]])
        return out


ALONE = Team()


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
        self.number = np.arange(self.n, dtype=libraries.PETSc.IntType)  # of each row in PETSc
        if team.size == 1:
            return
        filled = np.logical_or.reduce([np.diff(part.indptr) > 0 for part in parts])
        owner = team.least(np.where(filled, team.rank, team.size - 1))
        group = 2 * owner + (team.total(filled.astype(float)) > 1.0)
        # PETSc's order: process by process, of each the rows that others have entries in at the end
        self._order = np.argsort(group, kind="stable")
        bounds = np.searchsorted(group[self._order], np.arange(2 * team.size + 1))
        groups = [self._order[a:b] for a, b in pairwise(bounds)]
        inner, shared = groups[2 * team.rank], groups[1::2]
        self.rows = np.concatenate([inner, shared[team.rank]])
        self._elsewhere = np.concatenate([*shared[: team.rank], *shared[team.rank + 1 :]])
        self.n_own, self._n_inner = len(self.rows), len(inner)
        self.number[self._order] = np.arange(self.n)
        self._numbering = libraries.PETSc.LGMap().create(self.number, comm=libraries.MPI.COMM_SELF)

    def matrix(self, part: sp.csr_matrix, *, spd: bool) -> Any:
        """The sum of parts as a symmetric matrix of PETSc, which may be positive definite."""
        PETSc, comm = libraries.PETSc, self.team.comm
        size = (self.n_own, self.n), (self.n_own, self.n)  # of this process, of all
        index = part.indptr.astype(PETSc.IntType, copy=False)
        entries = index, part.indices.astype(PETSc.IntType, copy=False), part.data
        if self.team.size == 1:  # no copy, so that new values need no insertion
            mat = PETSc.Mat().createAIJWithArrays(size, csr=entries, comm=comm)
        else:
            mat = PETSc.Mat().createAIJ(size, nnz=self._lengths(part), comm=comm)
            mat.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
            mat.setLGMap(self._numbering, self._numbering)
            mat.setValuesLocalIJV(*entries, addv=True)
            mat.assemble()
        mat.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        if spd:  # MUMPS then runs with SYM=1, half an LU
            mat.setOption(PETSc.Mat.Option.SPD, True)
        return mat

    def _lengths(self, part: sp.csr_matrix) -> tuple[IntArray, ...]:
        """At most so many entries of the own rows are in own columns, and in those of others.

        The pattern is symmetric: rows of others in this part tell which own rows have columns of
        others. Of rows with entries of several processes, the sum of the lengths is the bound.
        """
        lengths = self.team.total(np.diff(part.indptr).astype(float))[self.rows]
        across = np.bincount(part[self._elsewhere].indices, minlength=self.n)[self.rows]
        across[self._n_inner :] = lengths[self._n_inner :]
        lengths[: self._n_inner] -= across[: self._n_inner]
        return tuple(
            np.minimum(count, most).astype(libraries.PETSc.IntType)
            for count, most in ((lengths, self.n_own), (across, self.n - self.n_own))
        )

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
    return part if team.size == 1 else Part(part, team).whole()


# Maximum time between the ranks at the end of an analysis, and after an error of one of them [s].
PATIENCE, AFTER_ERROR = 60.0, 20.0


class RankError(RuntimeError):
    """Another rank of the same analysis has failed."""


class Ranks(Team):
    """The ranks that mpirun started: all take part, rank 0 decides and writes."""

    def __init__(self) -> None:
        super().__init__(libraries.MPI.COMM_WORLD)
        self._private = libraries.MPI.COMM_WORLD.Dup()  # separate from the messages of an analysis

    def broadcast(self, value: Any) -> Any:
        """The value of rank 0, on every rank."""
        return self._private.bcast(value, root=0)

    def agree(self, error: BaseException | None) -> None:
        """Wait for the others; raises the first error of any of them.

        A rank whose partners do not arrive, because they wait for its part of a sum, ends the job.
        """
        request = self._private.Ibarrier()
        deadline = time.monotonic() + (PATIENCE if error is None else AFTER_ERROR)
        while not request.Test():
            if time.monotonic() > deadline:
                what = "the other ranks do not respond" if error is None else f"error: {error}"
                text = " ".join(f"rank {self.rank}: {what}; the job is aborted".split())
                print(text, file=sys.stderr, flush=True)
                self._private.Abort(2)
            time.sleep(0.001)
        for rank, message in enumerate(self._private.allgather(error and str(error))):
            if message is not None:
                raise error or RankError(f"rank {rank}: {message}")
