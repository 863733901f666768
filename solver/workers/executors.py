"""Where tasks are computed: in this process, in processes of this machine, by dask, by MPI."""

import argparse
import atexit
import gc
import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Future,
    ThreadPoolExecutor,
)
from concurrent.futures import Executor as PoolExecutor
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from queue import Empty, SimpleQueue
from types import ModuleType
from typing import Any, Protocol

from ..errors import InputError
from ..system.interrupts import ignore, shielded, stop_requested
from ..system.platform import context, processes

# What all executors have in common, and the loop that keeps one of them busy.

LOOK_S = 1.0  # time after which new workers get tasks even if none is done
FRUITLESS = 3  # lost tasks without a result in between, after which nothing more is tried
LOST = "lost the connection to the workers"


@dataclass(frozen=True)
class Task:
    """A call of a function; function, arguments and result can be pickled."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    content: Any = None  # what the source takes from it again; it does not travel


class Executor(Protocol):
    """Computes tasks in other threads, processes or machines."""

    name: str
    lost: tuple[type[BaseException], ...]  # errors of a task whose process ended

    def width(self) -> int:
        """Return how many tasks keep all workers busy, at least 1."""

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Begin a task. Tasks of one lane go to the same worker where that is possible.

        Parameters
        ----------
        lane : number of the lane
        function : the task
        arguments : its arguments
        """

    def close(self, *, at_once: bool) -> None:
        """End the workers that belong to it; `at_once`: without waiting for their tasks."""


class Source(Protocol):
    """Hands out tasks and takes their results."""

    def next(self, lane: int, width: int) -> Task | None:
        """Return a task for a lane, of as many as `width`; None if there is none now."""

    def took(self, task: Task, result: Any) -> None:
        """Take a result. A KeyboardInterrupt ends the distribution."""

    def lost(self, task: Task) -> None:
        """Handle a task whose worker process died."""


def distribute(executor: Executor, source: Source) -> None:
    """Have all tasks of a source computed, then close the executor.

    Raises
    ------
    KeyboardInterrupt
        A signal arrived; tasks under way are given up.
    InputError
        Workers die one after the other.
    """
    complete = False
    try:
        _run(executor, source)
        complete = True
    finally:
        executor.close(at_once=not complete)


def _run(executor: Executor, source: Source) -> None:
    """Keep all lanes busy. The effort for each task does not depend on the number of lanes."""
    under_way: dict[int, tuple[Future[Any], Task]] = {}
    done: SimpleQueue[int] = SimpleQueue()  # lanes
    waiting: list[int] = []  # lanes without a task
    lanes = deaths = 0
    while True:
        if stop_requested():  # while results were saved
            raise KeyboardInterrupt
        width = executor.width()
        waiting += range(lanes, width)
        lanes = max(lanes, width)
        while waiting and len(under_way) < width and (task := source.next(waiting[-1], width)):
            lane = waiting.pop()
            under_way[lane] = executor.submit(lane, task.function, *task.arguments), task
            under_way[lane][0].add_done_callback(partial(_note, done, lane))
        if not under_way:
            return
        try:
            lane = done.get(timeout=LOOK_S)
        except Empty:
            continue
        future, task = under_way.pop(lane)
        waiting.append(lane)
        try:
            result = future.result()
        except CancelledError:
            raise InputError(f"{executor.name}: {LOST}") from None
        except executor.lost:
            deaths += 1
            if deaths == FRUITLESS:
                raise InputError(f"{executor.name}: {FRUITLESS} workers died") from None
            source.lost(task)
        else:
            deaths = 0
            source.took(task, result)


def _note(done: "SimpleQueue[int]", lane: int, _: "Future[Any]") -> None:
    done.put(lane)


# Executors of this machine: this process, or workers of their own.

_MAIN = threading.Lock()  # held while a process starts
TASKS = 100  # of a process, after which a new one takes its place: its memory is free again


class Here:
    """Computes each task in this process, at once."""

    name = "this process"
    lost: tuple[type[BaseException], ...] = ()

    def width(self) -> int:
        """Return 1."""
        return 1

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Compute a task. Raises KeyboardInterrupt.

        Parameters
        ----------
        lane : not used
        function : the task
        arguments : its arguments
        """
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    def close(self, *, at_once: bool) -> None:
        """Do nothing."""


class _Worker:
    """A worker process, or a thread for tasks that wait for a process; who stops that ends them.

    A process ends with this one, however that ends. It does not import the main module of this one:
    tasks are functions of Plymotion, and a script of a user would begin again.
    """

    def __init__(self, *, thread: bool) -> None:
        self._links: tuple[Connection, ...] = ()
        if thread:
            self.pool: PoolExecutor = ThreadPoolExecutor(1)
            return
        # A fresh interpreter: threads and open files of this one are none of its own.
        theirs, ours = context(fresh=True).Pipe(duplex=False)
        self._links = ours, theirs
        self.pool = processes(1, _begin, theirs, fresh=True)

    def close(self, *, at_once: bool) -> None:
        for link in self._links[:1] if at_once else ():
            link.close()
        self.pool.shutdown(wait=not at_once or bool(self._links), cancel_futures=at_once)
        for link in self._links:
            link.close()


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
        self._workers: dict[int, _Worker] = {}
        self._tasks = dict.fromkeys(range(jobs), 0)

    def width(self) -> int:
        """Return the number of workers."""
        return self._jobs

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Begin a task on the worker of a lane, which is free; a new one where it died.

        Parameters
        ----------
        lane : number of the lane
        function : the task
        arguments : its arguments
        """
        if self._tasks[lane] == TASKS and not self._threads:
            self._workers.pop(lane).close(at_once=False)
            self._tasks[lane] = 0
        self._tasks[lane] += 1
        with suppress(KeyError, BrokenExecutor):
            return self._workers[lane].pool.submit(function, *arguments)
        if lane in self._workers:
            self._workers.pop(lane).close(at_once=True)
        with nullcontext() if self._threads else _starting():  # the process starts in `submit`
            self._workers[lane] = _Worker(thread=self._threads)
            return self._workers[lane].pool.submit(function, *arguments)

    def close(self, *, at_once: bool) -> None:
        """End all workers."""
        for worker in self._workers.values():
            worker.close(at_once=at_once)


@contextmanager
def _starting() -> Iterator[None]:
    """Start a process without the main module of this one, and without signals of a terminal."""
    with shielded(), _MAIN:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            yield
        finally:
            sys.modules["__main__"] = main


def _begin(link: Connection) -> None:
    """Prepare a worker process: ignore signals; exit when the parent exits."""
    ignore()
    # As in a command: looking for garbage takes a quarter of the time of a worker of one member.
    gc.set_threshold(50_000)
    atexit.register(gc.freeze)
    threading.Thread(target=_end_with, args=(link,), daemon=True).start()


def _end_with(link: Connection) -> None:
    with suppress(EOFError, OSError):
        link.recv()
    os._exit(1)  # nothing of it is left on a disk


# Executor of a dask cluster: workers on any number of machines, which may come and go.

QUEUED = 2  # tasks for each thread of a worker: the next one lies there when one is done
CONNECT_S = 10.0  # a scheduler that does not answer is not there


class Dask:
    """Computes tasks on the workers of a scheduler.

    Parameters
    ----------
    scheduler : address, such as "tcp://node7:8786", or the scheduler's file (*.json)

    Raises
    ------
    InputError
        dask.distributed is not installed, or no scheduler answers.
    """

    def __init__(self, scheduler: str) -> None:
        try:
            from distributed import Client
            from distributed.scheduler import KilledWorker
        except ImportError as error:
            raise InputError(
                f"--scheduler {scheduler}: needs dask.distributed ({error}): "
                "pip install distributed"
            ) from error
        for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
            # The end of a scheduler is a traceback there, and an InputError of `distribute`.
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self.name = f"--scheduler {scheduler}"
        file = Path(scheduler).suffix == ".json"
        if file and not Path(scheduler).is_file():
            raise InputError(
                f"{self.name}: no such file; `dask scheduler --scheduler-file` makes it"
            )
        where = {"scheduler_file" if file else "address": scheduler}
        try:
            self._client = Client(
                **where, timeout=CONNECT_S, set_as_default=False, name="plymotion"
            )
        except (OSError, ValueError, TypeError) as error:
            reason = " ".join(str(error).split())
            raise InputError(f"{self.name}: no dask scheduler answers there ({reason})") from error
        self._executor = self._client.get_executor(pure=False)
        self.lost: tuple[type[BaseException], ...] = (KilledWorker,)
        self._workers: list[str] = []  # addresses, one for each thread
        self._looked = 0.0

    def width(self) -> int:
        """Return two tasks for each thread of the workers that are there now."""
        if time.monotonic() - self._looked > LOOK_S or not self._workers:
            try:
                threads = self._client.nthreads()
            except OSError:  # of dask, when the scheduler has gone and it tries again
                raise InputError(f"{self.name}: {LOST}") from None
            self._workers = [worker for worker, count in threads.items() for _ in range(count)]
            self._looked = time.monotonic()
        return max(1, QUEUED * len(self._workers))

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Begin a task; another worker than the lane's takes it if that one is gone or busy.

        Parameters
        ----------
        lane : number of the lane
        function : the task
        arguments : its arguments
        """
        hint: dict[str, object] = {}
        if self._workers:
            worker = self._workers[lane % len(self._workers)]
            hint = {"workers": [worker], "allow_other_workers": True}
        future: Future[Any] = self._executor.submit(function, *arguments, **hint)
        return future

    def close(self, *, at_once: bool) -> None:
        """Leave the cluster; workers finish the task that they are at."""
        self._executor.shutdown(wait=not at_once)
        self._client.close()


# Executor of an MPI job: rank 0 distributes, every other rank computes.

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
        """Begin a task on the next rank that is free.

        Parameters
        ----------
        lane : not used
        function : the task
        arguments : its arguments
        """
        future: Future[Any] = self._pool.submit(function, *arguments)
        return future

    def close(self, *, at_once: bool) -> None:
        """End the other ranks when they have done the tasks that they are at."""
        self._pool.shutdown(wait=True, cancel_futures=at_once)


# The executor that options choose.


def executor_of(options: argparse.Namespace, *, threads: bool = False) -> "Executor":
    """Return the executor that the options ask for.

    Parameters
    ----------
    threads : tasks do no work in this process themselves, so threads of it are enough

    Raises
    ------
    InputError
        Options that contradict each other, or an executor that is not there.
    """
    kind = options.executor or ("dask" if options.scheduler else "local")
    if options.scheduler and kind != "dask":
        raise InputError(f"--scheduler {options.scheduler}: expected with --executor dask only")
    if kind != "local" and options.jobs:
        raise InputError(f"--jobs {options.jobs}: expected with --executor local only")
    if kind == "dask":
        if not options.scheduler:
            raise InputError("--executor dask: expected --scheduler ADDRESS or FILE.json as well")

        return Dask(options.scheduler)
    if kind == "mpi":
        return Mpi()

    jobs = options.jobs or 1
    return Here() if jobs == 1 and not threads else Local(jobs, threads=threads)
