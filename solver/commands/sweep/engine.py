"""Compute the members of a sweep in portions, here or by worker processes."""

import multiprocessing
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection, wait
from pathlib import Path

from ...errors import InputError
from ...interrupts import asked, ignore
from ...results.codes.members import WORKER_LOST
from .member import FAILED, Packages, Row, compute
from .plan import Plan, read_plan

PORTION_S = 2.0  # time that a portion of members should take: progress is told after each
FRUITLESS = 3  # deaths of workers without a result in between, after which nothing more is tried
LOST = "the process that computed it died (out of memory?)"

Report = Callable[[int, Row], None]


class Portions:
    """Hand out members in portions that grow while they are quick."""

    def __init__(self, numbers: Sequence[int]) -> None:
        self._left = list(reversed(numbers))
        self._alone: list[int] = []
        self._size = 1

    def next(self) -> list[int]:
        """Return the next members; none if there is nothing left."""
        if self._alone:
            return [self._alone.pop()]
        return [self._left.pop() for _ in range(min(self._size, len(self._left)))]

    def took(self, count: int, seconds: float) -> None:
        """Learn from a portion that has been computed."""
        if count >= self._size:
            wanted = round(count * PORTION_S / max(seconds, 1e-6))
            self._size = max(1, min(2 * self._size, wanted))

    def one_by_one(self, numbers: Sequence[int]) -> None:
        """Take members back, to be handed out each alone."""
        self._alone += numbers


def compute_here(plan: Plan, numbers: Sequence[int], keys: Sequence[str], report: Report) -> bool:
    """Compute members in this process; return False if it was interrupted (Ctrl-C)."""
    packages = Packages(plan)
    portions = Portions(numbers)
    try:
        while portion := portions.next():
            begin = time.perf_counter()
            rows = compute(plan, packages, portion, [keys[k] for k in portion])
            for number, row in zip(portion, rows, strict=True):
                if row.done:
                    report(number, row)
            if asked() or not all(row.done for row in rows):
                return False
            portions.took(len(portion), time.perf_counter() - begin)
    except KeyboardInterrupt:
        return False
    return True


class _Worker:
    """A process that computes one portion after the other."""

    def __init__(self, plan: Plan) -> None:
        # A fresh interpreter: threads and open files of this one are none of its own.
        context = multiprocessing.get_context("spawn")
        self.link, there = context.Pipe()
        self.process = context.Process(
            target=_work, args=(plan.file, plan.allow_doubtful, there), daemon=True
        )
        self.process.start()
        there.close()
        self.portion: list[int] = []
        self.begun = 0.0

    def give(self, portion: list[int], keys: Sequence[str]) -> None:
        self.portion, self.begun = portion, time.perf_counter()
        self.link.send((portion, [keys[k] for k in portion]))

    def end(self) -> None:
        self.process.kill()  # nothing of it is left on a disk
        self.process.join()
        self.link.close()


def compute_by_workers(
    plan: Plan, numbers: Sequence[int], keys: Sequence[str], jobs: int, report: Report
) -> bool:
    """Compute members by worker processes; return False if it was interrupted.

    A worker that dies takes only the member with it that it was at.

    Raises
    ------
    InputError
        Workers die at once.
    """
    portions = Portions(numbers)
    crew: list[_Worker] = []
    deaths = 0

    def start() -> None:
        if portion := portions.next():
            crew.append(_Worker(plan))
            crew[-1].give(portion, keys)

    try:
        for _ in range(jobs):
            start()
        while crew:
            if asked():  # while rows were saved
                return False
            links = wait([worker.link for worker in crew])
            for worker in [w for w in crew if w.link in links]:
                try:
                    rows: list[Row] = worker.link.recv()
                except (EOFError, ConnectionError):
                    deaths += 1
                    crew.remove(worker)
                    worker.end()
                    if deaths == FRUITLESS:
                        raise InputError(f"--jobs {jobs}: {FRUITLESS} workers died") from None
                    if len(worker.portion) == 1:
                        number = worker.portion[0]
                        row = Row(keys[number], status=FAILED, message=LOST, code=WORKER_LOST.name)
                        report(number, row)
                    else:
                        portions.one_by_one(worker.portion)
                    start()
                    continue
                deaths = 0
                for number, row in zip(worker.portion, rows, strict=True):
                    report(number, row)
                portions.took(len(rows), time.perf_counter() - worker.begun)
                if portion := portions.next():
                    worker.give(portion, keys)
                else:
                    crew.remove(worker)
                    worker.end()
    except KeyboardInterrupt:
        return False
    finally:
        for worker in crew:
            worker.end()
    return True


def _work(file: Path, allow_doubtful: bool, link: Connection) -> None:
    """Compute what comes over the link until it closes. The parent process minds signals."""
    ignore()
    plan = read_plan(file, allow_doubtful=allow_doubtful)
    packages = Packages(plan)
    while True:
        try:
            numbers, keys = link.recv()
        except EOFError:
            return
        link.send(compute(plan, packages, numbers, keys))
