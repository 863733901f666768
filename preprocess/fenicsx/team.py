"""The processes that work on one analysis together."""

from typing import Any

import numpy as np

from ...solver.math.arrays import Array, IntArray


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
            from .stack import MPI

            self._comm = MPI.COMM_SELF
        return self._comm

    def share(self, count: int) -> slice:
        """The share of `count` items of this process."""
        return slice(count * self.rank // self.size, count * (self.rank + 1) // self.size)

    def total(self, part: Array) -> Array:
        """Sum over the team, returned on all processes."""
        if self.size == 1:
            return part
        out = np.empty_like(part)
        self.comm.Allreduce(np.ascontiguousarray(part), out)
        return out

    def least(self, values: IntArray) -> IntArray:
        """The least values over the team, on all processes."""
        from .stack import MPI

        self.comm.Allreduce(MPI.IN_PLACE, values, op=MPI.MIN)
        return values

    def stacked(self, part: Array) -> Array:
        """Concatenated rows of all processes, returned on all processes."""
        return np.concatenate(self.comm.allgather(part)) if self.size > 1 else part


ALONE = Team()


def world() -> Team:
    """All processes that mpirun started."""
    from .stack import MPI

    return Team(MPI.COMM_WORLD)
