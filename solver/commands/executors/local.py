"""Executors of this machine: this process, or workers of their own."""

import atexit
import gc
import os
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import nullcontext, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from ...interrupts import ignore, shielded

TASKS = 100  # of a process, after which a new one takes its place: its memory is free again


class Here:
    """Computes each task in this process, at once."""

    name = "this process"
    lost: tuple[type[BaseException], ...] = ()

    def width(self) -> int:
        """Return 1."""
        return 1

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Compute a task. Raises KeyboardInterrupt."""
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    def close(self, *, at_once: bool) -> None:
        """Do nothing."""


class _Process:
    """One worker process. It ends with this one, however that ends."""

    def __init__(self) -> None:
        # A fresh interpreter: threads and open files of this one are none of its own.
        context = get_context("spawn")
        self._theirs, self._ours = context.Pipe(duplex=False)
        self.pool = ProcessPoolExecutor(1, context, _begin, (self._theirs,))

    def close(self, *, at_once: bool) -> None:
        if at_once:
            self._ours.close()
        self.pool.shutdown(cancel_futures=at_once)
        self._ours.close()
        self._theirs.close()


class _Thread:
    """One worker thread, for tasks that wait for a process; whoever stops that ends the task."""

    def __init__(self) -> None:
        self.pool = ThreadPoolExecutor(1)

    def close(self, *, at_once: bool) -> None:
        self.pool.shutdown(wait=not at_once, cancel_futures=at_once)


class Local:
    """A worker for each lane.

    Parameters
    ----------
    jobs : number of workers
    threads : workers are threads of this process
    """

    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)

    def __init__(self, jobs: int, *, threads: bool = False) -> None:
        self.name = f"--jobs {jobs}"
        self._jobs, self._threads = jobs, threads
        self._workers: dict[int, _Process | _Thread] = {}
        self._tasks = dict.fromkeys(range(jobs), 0)

    def width(self) -> int:
        """Return the number of workers."""
        return self._jobs

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Begin a task on the worker of a lane, which is free; a new one where it died."""
        if self._tasks[lane] == TASKS and not self._threads:
            self._workers.pop(lane).close(at_once=False)
            self._tasks[lane] = 0
        self._tasks[lane] += 1
        with suppress(KeyError, BrokenExecutor):
            return self._workers[lane].pool.submit(function, *arguments)
        if lane in self._workers:
            self._workers.pop(lane).close(at_once=True)
        with nullcontext() if self._threads else shielded():  # the process starts in `submit`
            self._workers[lane] = _Thread() if self._threads else _Process()
            return self._workers[lane].pool.submit(function, *arguments)

    def close(self, *, at_once: bool) -> None:
        """End all workers."""
        for worker in self._workers.values():
            worker.close(at_once=at_once)


def _begin(link: Connection) -> None:
    """Prepare a worker process: it leaves signals to the parent, and ends when that lets go."""
    ignore()
    # As in a command: looking for garbage takes a quarter of the time of a worker of one member.
    gc.set_threshold(50_000)
    atexit.register(gc.freeze)
    threading.Thread(target=_end_with, args=(link,), daemon=True).start()


def _end_with(link: Connection) -> None:
    with suppress(EOFError, OSError):
        link.recv()
    os._exit(1)  # nothing of it is left on a disk
