"""The rows of a sweep: handed out to an executor in portions, computed and saved."""

import logging
import math
import platform
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from tqdm import tqdm

from ...checks.finished_run import FinishedRun, Look
from ...checks.judge import judge
from ...errors import InputError, PackageError
from ...inputs.case.messages import ERRORS, out_of_range
from ...inputs.case.record import solver_sha256, with_parts
from ...math.arrays import Array
from ...math.compiled import COMPILED, tell_if_slow
from ...math.disk_cache import state_of
from ...package import ModalPackage
from ...package.common.plain_data import data_sha256
from ...results import ResultError, Signal, signal_summary
from ...results.codes import DEFECT, INPUT, PACKAGE, WORKER_LOST
from ...run.error_bars import error_bars
from ...run.execution import execute
from ...run.inputs import RunSpec
from ...run.preparation import histories_of, integrated, output_times, prepare
from ...signals import Recording, Sensor, fatigue_entry
from ...strength.fatigue import Turning
from ...system.interrupts import completing
from ...workers.executors import Executor, Local, Task, distribute
from .file import (
    CHECKS,
    COST,
    DAMAGE,
    ERROR_BAR,
    FAILED,
    FINISHED,
    INTERRUPTED,
    Row,
    believed_rows,
    result_of,
    write_sweep,
)
from .sweep_members import Member, Packages, SweepSpec, read_sweep_spec

# One member of a sweep: what is kept of its motion.

# Every check of a single run, at fewer output times.
LOOK = Look(balance=101, momentum=3, stiffening=41, strength=101)


def compute(
    sweep: SweepSpec, packages: Packages, numbers: Sequence[int], keys: Sequence[str]
) -> list[Row]:
    """Return the rows of some members, one after the other; an error in one concerns it alone.

    Rows of members that an interruption (Ctrl-C) left without an end are pending.

    Parameters
    ----------
    numbers, keys : of the members; keys go into the rows
    """
    rows = [Row(key) for key in keys]
    for k, number in enumerate(numbers):
        try:
            rows[k] = _computed(sweep, packages, number, rows[k])
        except KeyboardInterrupt:
            break
        except Exception as error:
            if isinstance(error, ERRORS) and (
                message := out_of_range(sweep.name, sweep.mechanism_of(number).model_dump())
            ):
                error = InputError(message)
            rows[k] = _failed(rows[k], error)
        if not rows[k].done:
            break
    return rows


def _computed(sweep: SweepSpec, packages: Packages, number: int, row: Row) -> Row:
    """Return the row of a member, integrated and judged as a single run is.

    Pending if the integration was interrupted.
    """
    begin = time.perf_counter()
    mechanism = sweep.mechanism_of(number)
    kept = {*sweep.signals, *sweep.histories}
    member = sweep.members[number]
    others = {
        run: RunSpec(
            sweep.case, run, sweep.mechanism_of(number, run), packages.named(variant.packages)
        )
        for run, variant in member.other_runs.items()
    }
    read = with_parts(kept, mechanism.signals)
    own = RunSpec(sweep.case, sweep.run, mechanism, packages.named(member.packages), others)
    if sweep.fidelity is not None:
        own = _planned(own, sweep, packages.named(sweep.fidelity.base))
    histories = histories_of(read, others, own.mechanism.solver)
    prepared = prepare(own.mechanism, own.packages, kept, histories=histories)
    finished = integrated(prepared, look=LOOK)
    if finished.solution.status == INTERRUPTED:
        return row
    seconds = time.perf_counter() - begin
    times = output_times(mechanism.solver.t_end, mechanism.solver.output_step)
    return _row_of(own, sweep, row, finished, prepared.measured, times, seconds)


def _planned(spec: RunSpec, sweep: SweepSpec, packages: dict[str, ModalPackage]) -> RunSpec:
    """Return a member with the model of the plan that the command has written.

    `packages` are those of the base. Raises InputError: there is no plan, or it is wrong.
    """
    from ..fidelity.checked_run import member_spec
    from ..fidelity.choice import read_plan  # most sweeps need no planner
    from ..fidelity.plan import known_vibrations

    file = sweep.model_plan_file
    if not file.is_file():
        raise InputError(f"{file}: no such file; expected the plan that `plymotion sweep` makes")
    base = RunSpec(sweep.case, sweep.run, sweep.base, packages)
    return member_spec(spec, read_plan(file, known_vibrations(base)))


def _failed(row: Row, error: Exception) -> Row:
    """Return the row of a member that ended in an error."""
    message = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, InputError | PackageError):
        code = PACKAGE if isinstance(error, PackageError) else INPUT
        return replace(row, status=FAILED, message=message, code=code.name)
    message, trace = f"{type(error).__name__}: {message}", traceback.format_exception(error)
    return replace(row, status=FAILED, message=message, code=DEFECT.name, defect="".join(trace))


def _row_of(
    spec: RunSpec,
    sweep: SweepSpec,
    row: Row,
    finished: FinishedRun,
    sensors: Mapping[str, Sensor],
    times: Array,
    seconds: float,
) -> Row:
    """Return the row of a member from its run; `times` (n_t,) are those of a complete one."""
    solution = finished.solution
    t = solution.t
    recording = Recording(finished.model, t, solution.y)
    names = dict.fromkeys((*sweep.signals, *sweep.histories))
    series = {
        name: Signal(name, sensor.unit, sensor.description, sensor.values(recording))
        for name, sensor in ((name, sensors[name]) for name in names)
    }
    kept = int(np.searchsorted(times, t[-1], side="right"))
    histories = {}
    for name in sweep.histories:
        histories[name] = np.full(times.size, np.nan)
        histories[name][:kept] = series[name].values[:kept]
    signals = {name: signal_summary(series[name], t) for name in sweep.signals}
    for name in sweep.signals:
        if sensors[name].life is not None:  # Miner's sum of a stress with an S-N line
            turning = Turning()
            turning.take(series[name].values * sensors[name].scale)
            signals[name] |= {DAMAGE: fatigue_entry(sensors[name], turning)["damage"]}
    judgement = judge(finished)
    counters = vars(solution.counters)
    if spec.mechanism.solver.error_bars and solution.status == FINISHED:
        again, steps = partial(execute, progress=False), int(counters["steps"])
        read = with_parts(names, spec.mechanism.signals)  # others may need runs that are not there
        asked = spec.changed({"signals": {name: one.model_dump() for name, one in read.items()}})
        bars, _ = error_bars(asked, t, [*series.values()], steps, judgement.codes, again)
        for name in sweep.signals:
            signals[name][ERROR_BAR] = np.nan if bars[name] is None else bars[name]
    return replace(
        row,
        status=solution.status,
        message="" if solution.status == FINISHED else solution.message,
        code=solution.code,
        t_end=float(t[-1]),
        signals=signals,
        histories=histories,
        checks={name: judgement.numbers[name] for name in CHECKS},
        cost={name: float(counters.get(name, seconds)) for name in COST},
        warnings=judgement.codes,
    )


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
