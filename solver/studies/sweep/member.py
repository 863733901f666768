"""One member of a sweep: what is kept of its motion."""

import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...checks.finished import FinishedRun, Look
from ...checks.judge import judge
from ...errors import InputError, PackageError
from ...inputs.case.messages import ERRORS, out_of_range
from ...inputs.case.record import with_parts
from ...math.arrays import Array
from ...package import ModalPackage
from ...results import Signal, signal_summary
from ...results.codes import DEFECT, INPUT, PACKAGE
from ...run.error_bars import error_bars
from ...run.execution import execute
from ...run.inputs import RunSpec
from ...run.preparation import histories_of, integrated, output_times, prepare
from ...signals import Recording, Sensor, fatigue_entry
from ...strength.fatigue import Turning
from .file import CHECKS, COST, DAMAGE, ERROR_BAR, FAILED, FINISHED, INTERRUPTED, Row
from .sweep_members import Packages, SweepSpec

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
