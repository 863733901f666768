"""The processes that work on one analysis together."""

from typing import Any

import numpy as np

from .stack import MPI, Array


class Team:
    """Processes that hold the same mesh and share out its cells and the factorisation.

    Every number is the same on all of them; what is summed over cells is summed over the team.
    """

    def __init__(self, comm: Any) -> None:
        self.comm = comm
        self.rank = int(comm.rank)
        self.size = int(comm.size)

    def share(self, count: int) -> slice:
        """Which of `count` things are this process's."""
        return slice(count * self.rank // self.size, count * (self.rank + 1) // self.size)

    def total(self, part: Array) -> Array:
        """Sum over the team, on all of them."""
        if self.size == 1:
            return part
        out = np.empty_like(part)
        self.comm.Allreduce(np.ascontiguousarray(part), out)
        return out

    def stacked(self, part: Array) -> Array:
        """Rows of all processes below each other, on all of them."""
        return np.concatenate(self.comm.allgather(part)) if self.size > 1 else part


ALONE = Team(MPI.COMM_SELF)


def world() -> Team:
    """All processes that mpirun started."""
    return Team(MPI.COMM_WORLD)
