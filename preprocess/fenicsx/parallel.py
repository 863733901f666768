"""Several processes by MPI: the ranks of one analysis, or a pool of workers."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from mpi4py.futures import MPICommExecutor, MPIPoolExecutor

from .stack import MPI
from .team import Team

# Maximum time between the ranks at the end of an analysis, and after an error of one of them [s].
PATIENCE, AFTER_ERROR = 60.0, 20.0


class RankError(RuntimeError):
    """Another rank of the same analysis has failed."""


class Ranks(Team):
    """The ranks that mpirun started: all take part, rank 0 decides and writes."""

    def __init__(self) -> None:
        super().__init__(MPI.COMM_WORLD)
        self._private = MPI.COMM_WORLD.Dup()  # separate from the messages of an analysis

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
        for rank, found in enumerate(self._private.allgather(error and str(error))):
            if found is not None:
                raise error or RankError(f"rank {rank}: {found}")


def world_size() -> int:
    """Number of processes that mpirun started; 1 without it."""
    return int(MPI.COMM_WORLD.size)


@contextmanager
def pool() -> Iterator[Any]:
    """An executor over all ranks except the first; None on a rank that has finished its work.

    There are two ways to start: `mpirun -n N python -m mpi4py.futures -m MODULE ...`, where
    only rank 0 calls this, and `mpirun -n N python -m MODULE ...`, where all ranks do.
    """
    if "mpi4py.futures" in sys.orig_argv:
        with MPIPoolExecutor(max_workers=world_size() - 1, main=False) as executor:
            yield executor
    else:
        with MPICommExecutor(MPI.COMM_WORLD, root=0) as executor:
            yield executor
