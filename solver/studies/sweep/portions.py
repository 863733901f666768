"""The rows of a sweep: handed out to an executor in portions, computed and saved."""

import logging
import math
import platform
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from tqdm import tqdm

from ...errors import InputError
from ...inputs.case.record import solver_sha256
from ...math.compiled import COMPILED, tell_if_slow
from ...math.disk_cache import state_of
from ...package.common.plain_data import data_sha256
from ...results import ResultError
from ...results.codes import WORKER_LOST
from ...system.interrupts import completing
from ...workers.executors import Executor, Local, Task, distribute
from .file import FAILED, Row, believed_rows, result_of, write_sweep
from .member import compute
from .sweep_members import Member, Packages, SweepSpec, read_sweep_spec

# A portion of the members of a sweep: what a worker computes at a time.

_ALONE = threading.Lock()  # workers of dask may have several threads; integrators share memory


@dataclass(frozen=True)
class PortionSpec:
    """What all portions of a sweep have in common."""

    file: Path  # the sweep file, under the same name for all workers
    content: str  # digest of the sweep and its packages: another one is read again
    solver: str  # digest of the solver's sources
    allow_doubtful: bool


def compute_portion(
    common: PortionSpec, members: Sequence[Member], keys: Sequence[str]
) -> tuple[list[Row], float]:
    """Return the rows of some members and the time that they took [s].

    Rows that an interruption left without an end are pending.

    Parameters
    ----------
    common : sweep file, packages and digest of the sources
    members : members of the portion
    keys : names of the numbers of a row

    Raises
    ------
    InputError
        The sweep file cannot be read here, or the sources of this worker are others.
    """
    begin = time.perf_counter()
    if solver_sha256() != common.solver:
        raise InputError(
            f"{platform.node()}: the worker has other sources of Plymotion than the command: "
            "restart the workers"
        )
    with _ALONE:
        sweep, packages = _read(common)
        rows = compute(sweep.part(members), packages, range(len(members)), keys)
    return rows, time.perf_counter() - begin


@lru_cache(maxsize=1)
def _read(common: PortionSpec) -> tuple[SweepSpec, Packages]:
    sweep = read_sweep_spec(common.file, allow_doubtful=common.allow_doubtful)
    return sweep, Packages(sweep)


# The members of a sweep, handed out to an executor in portions.

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
        sweep: SweepSpec,
        numbers: Sequence[int],
        keys: Sequence[str],
        report: Callable[[int, Row], None],
    ) -> None:
        self._sweep, self._keys, self._report = sweep, keys, report
        self._order = PortionSpec(
            sweep.file.resolve(), data_sha256(list(keys)), solver_sha256(), sweep.allow_doubtful
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
        members = [self._sweep.members[k] for k in numbers]
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


# The rows of a sweep: what is known, what is computed, and when it is saved.

LOGGER = logging.getLogger(__name__)
SAVE_S = 10.0  # least time between two savings on the way


def settled(sweep: SweepSpec) -> list[str]:
    """Make the plan of a run with [fidelity], or read it, before members take it.

    Return what is known of it; nothing if the run has no [fidelity]. Raises as `fidelity.settle`.
    """
    if sweep.fidelity is None:
        return []
    from .fidelity import settle  # most sweeps need no planner

    return settle(sweep)


class RowFile:
    """Rows of a sweep as they come, and the file that they are saved in.

    Parameters
    ----------
    file : of the rows
    known_in : files that may have some already
    """

    def __init__(
        self, sweep: SweepSpec, file: Path, known_in: Sequence[Path], *, show: bool
    ) -> None:
        self.sweep, self.file, self.show = sweep, file, show
        self._read = self._states()
        self.keys = sweep.keys()
        known = {key: row for path in known_in for key, row in _known(path).items()}
        self.rows = [known.get(key, Row(key)) for key in self.keys]
        self.kept = sum(row.done for row in self.rows)
        self._saved = time.perf_counter()

    def compute(self, executor: Callable[[], Executor]) -> bool:
        """Compute what is pending; False if interrupted. What is known then is in the file."""
        numbers = [k for k, row in enumerate(self.rows) if not row.done]
        with tqdm(
            total=len(self.rows),
            initial=self.kept,
            desc=self.sweep.name,
            unit="member",
            disable=None if self.show else True,
            leave=False,
        ) as bar:

            def report(number: int, row: Row) -> None:
                for file, state in self._states().items():
                    if state != self._read[file]:
                        raise InputError(
                            f"{file}: was changed while the sweep ran; the same command computes "
                            "the members that are left"
                        )
                self.rows[number] = row
                if row.defect:
                    LOGGER.error("%sthis is a defect of the solver, not of the input", row.defect)
                bar.update()
                if time.perf_counter() - self._saved > SAVE_S:
                    self.save()

            try:
                if numbers:
                    place, portions = executor(), Portions(self.sweep, numbers, self.keys, report)
                    tell_if_slow()
                    if isinstance(place, Local) and COMPILED:  # before all workers do
                        from ..compiling import compile_once

                        compile_once()
                    distribute(place, portions)
                return True
            except KeyboardInterrupt:
                return False
            finally:
                self.save()

    def _states(self) -> dict[Path, list[int]]:
        """Return the states of the files that workers read."""
        packages = (self.sweep.package_file(k) for k in range(len(self.sweep.packages)))
        return {file: state_of(file) for file in (self.sweep.file, *packages)}

    def save(self) -> None:
        """Write the file; it is whole at any time."""
        with completing():
            write_sweep(self.file, result_of(self.sweep, self.rows))
        self._saved = time.perf_counter()


def _known(file: Path) -> dict[str, Row]:
    """Return the rows of an earlier sweep by key; an unreadable file is reported and ignored."""
    if not file.is_file():
        return {}
    try:
        rows, altered = believed_rows(file)
        if altered:
            LOGGER.warning(
                "%s: %d rows were altered after writing; they are computed again", file, altered
            )
        return rows
    except ResultError as error:
        LOGGER.warning("%s; everything is computed again", error)
        return {}
