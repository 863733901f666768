"""What all executors have in common, and the loop that keeps one of them busy."""

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from typing import Any, Protocol

from ...errors import InputError
from ...interrupts import asked

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
    under_way: dict[int, tuple[Future[Any], Task]] = {}
    deaths = 0
    while True:
        if asked():  # while results were saved
            raise KeyboardInterrupt
        width = executor.width()
        for lane in range(width):
            if lane not in under_way and (task := source.next(lane, width)):
                under_way[lane] = executor.submit(lane, task.function, *task.arguments), task
        if not under_way:
            return
        wait([future for future, _ in under_way.values()], return_when=FIRST_COMPLETED)
        for lane in [n for n, (future, _) in under_way.items() if future.done()]:
            future, task = under_way.pop(lane)
            try:
                result = future.result()
            except CancelledError:
                raise InputError(
                    f"{executor.name}: the connection to the workers is lost"
                ) from None
            except executor.lost:
                deaths += 1
                if deaths == FRUITLESS:
                    raise InputError(f"{executor.name}: {FRUITLESS} workers died") from None
                source.lost(task)
            else:
                deaths = 0
                source.took(task, result)
