"""Executor of an MPI job: rank 0 distributes, every other rank computes."""

import sys
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from ...errors import InputError

START = "mpirun -n N python -m mpi4py.futures -m plymotion.solver ..."


class Mpi:
    """Computes tasks on the ranks of the job that this process is rank 0 of.

    A rank that dies ends the whole job; what was saved before is kept.

    Raises
    ------
    InputError
        mpi4py is not installed, or the command was started in another way.
    """

    name = "--executor mpi"
    lost: tuple[type[BaseException], ...] = ()

    def __init__(self) -> None:
        if "mpi4py.futures" not in sys.orig_argv:
            raise InputError(f"{self.name}: expected a start by `{START}`")
        from mpi4py import MPI
        from mpi4py.futures import MPIPoolExecutor

        self._ranks = MPI.COMM_WORLD.size - 1
        if self._ranks < 1:
            raise InputError(f"{self.name}: expected two ranks or more, found one: `{START}`")
        self._pool = MPIPoolExecutor(max_workers=self._ranks, main=False)

    def width(self) -> int:
        """Return two tasks for each rank: the next one waits when one is done."""
        return 2 * self._ranks

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Begin a task on the next rank that is free."""
        future: Future[Any] = self._pool.submit(function, *arguments)
        return future

    def close(self, *, at_once: bool) -> None:
        """End the other ranks when they have done the tasks that they are at."""
        self._pool.shutdown(wait=True, cancel_futures=at_once)
