"""What all executors have in common, and the loop that keeps one of them busy."""

from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any, Protocol

from ...errors import InputError
from ...interrupts import asked

LOOK_S = 1.0  # time after which new workers get tasks even if none is done
FRUITLESS = 3  # lost tasks without a result in between, after which nothing more is tried


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
        """Begin a task. Tasks of one lane go to the same worker where that is possible."""

    def close(self, *, at_once: bool) -> None:
        """End the workers that belong to it; `at_once`: without waiting for their tasks."""


class Source(Protocol):
    """Hands out tasks and takes their results."""

    def next(self, lane: int, width: int) -> Task | None:
        """Return a task for a lane, of as many as `width`; None if there is none now."""

    def took(self, task: Task, result: Any) -> None:
        """Take a result. A KeyboardInterrupt ends the distribution."""

    def lost(self, task: Task) -> None:
        """Take notice that the process of a task ended before the task."""


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
        if asked():  # while results were saved
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
            raise InputError(f"{executor.name}: lost the connection to the workers") from None
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
