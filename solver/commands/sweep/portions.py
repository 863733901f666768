"""The members of a sweep, handed out to an executor in portions."""

import math
from collections.abc import Callable, Sequence

from ...inputs.case.sources import solver_sha256
from ...package.common.plain_data import data_sha256
from ...results.codes import WORKER_LOST
from ..executors.executor import Task
from .member import FAILED, Row
from .plan import Plan
from .portion import Order, compute_portion

PORTION_S = 2.0  # time that a portion of members should take: progress is reported after each
LOST = "the process that computed it died (out of memory?)"


class Portions:
    """Hands out members in portions that grow while they are quick.

    A worker that dies takes only the member with it that it was at.

    Parameters
    ----------
    numbers : of the members that are to be computed
    keys : of all members
    report : called with each row
    """

    def __init__(
        self,
        plan: Plan,
        numbers: Sequence[int],
        keys: Sequence[str],
        report: Callable[[int, Row], None],
    ) -> None:
        self._plan, self._keys, self._report = plan, keys, report
        self._order = Order(
            plan.file.resolve(), data_sha256(list(keys)), solver_sha256(), plan.allow_doubtful
        )
        self._left = list(reversed(numbers))
        self._alone: list[int] = []
        self._size = 1

    def next(self, lane: int, width: int) -> Task | None:
        """Return the next members; small portions at the end, so that all workers end together."""
        if self._alone:
            numbers = [self._alone.pop()]
        else:
            size = min(self._size, math.ceil(len(self._left) / (2 * width)))
            numbers = [self._left.pop() for _ in range(size)]
        if not numbers:
            return None
        members = [self._plan.members[k] for k in numbers]
        keys = [self._keys[k] for k in numbers]
        return Task(compute_portion, (self._order, members, keys), numbers)

    def took(self, task: Task, result: tuple[list[Row], float]) -> None:
        """Report rows. Raises KeyboardInterrupt if the computation was interrupted."""
        rows, seconds = result
        for number, row in zip(task.content, rows, strict=True):
            if row.done:
                self._report(number, row)
        if not all(row.done for row in rows):
            raise KeyboardInterrupt
        if len(rows) >= self._size:
            wanted = round(len(rows) * PORTION_S / max(seconds, 1e-6))
            self._size = max(1, min(2 * self._size, wanted))

    def lost(self, task: Task) -> None:
        """Hand members out again, each alone; one that was alone has failed."""
        if len(task.content) > 1:
            self._alone += task.content
            return
        (number,) = task.content
        row = Row(self._keys[number], status=FAILED, message=LOST, code=WORKER_LOST.name)
        self._report(number, row)
