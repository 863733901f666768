"""One member of a sweep: what is kept of its motion."""

import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...checks import findings
from ...dynamics.freedom import degrees_of_freedom
from ...errors import InputError, PackageError
from ...integrators.generic import Solution
from ...math.arrays import Array
from ...monitors.spin import SPIN_CODE
from ...package import ModalPackage
from ...results import Signal, relative_balance, signal_summary
from ...run.ensemble import integrate_members, structure
from ...run.execution import output_times
from ...run.preparation import Prepared, prepare
from ...signals import Recording, recover
from ...signals.reactions import momentum_balance
from .plan import Plan

PENDING, FINISHED, STOPPED, FAILED = "pending", "finished", "stopped", "failed"
INTERRUPTED = "interrupted"
MEASURES = ("final", "min", "t_min", "max", "t_max")
CHECKS = (
    "constraint_position_max",
    "constraint_rotation_max",
    "constraint_velocity_max",
    "energy_drift_relative",
    "drive_work",
)
COST = ("solve_s", "steps", "rejected", "evaluations", "jacobians", "factorisations")
JUDGED_TIMES = 101  # at most, at which constraints and energies are looked at
BALANCED_TIMES = 3  # at most, at which reactions are held against momenta


@dataclass(frozen=True)
class Row:
    """What a sweep keeps of one member; empty tables where it has nothing to tell."""

    key: str
    status: str = PENDING  # pending, finished, stopped, failed
    message: str = ""
    code: str = ""
    t_end: float = np.nan  # [s]
    signals: dict[str, dict[str, Any]] = field(default_factory=dict)  # unit and MEASURES
    histories: dict[str, Array] = field(default_factory=dict)  # (n_t,), NaN after an early end
    checks: dict[str, float] = field(default_factory=dict)
    cost: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()  # codes
    defect: str = ""  # traceback of an error that is none of the user's; not kept in the file

    @property
    def done(self) -> bool:
        """Whether there is nothing left to compute."""
        return self.status != PENDING


class Packages:
    """Packages of a plan, each read once; one that cannot be read fails its members."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._known: dict[int, ModalPackage | PackageError] = {}

    def of(self, number: int) -> dict[str, ModalPackage]:
        """Return the packages of one member by body. Raises PackageError."""
        found = {}
        for body, k in self.plan.members[number].packages.items():
            if k not in self._known:
                try:
                    self._known[k] = self.plan.package(k)
                except PackageError as error:
                    self._known[k] = error
            package = self._known[k]
            if isinstance(package, PackageError):
                raise PackageError(str(package))
            found[body] = package
        return found


def compute(
    plan: Plan, packages: Packages, numbers: Sequence[int], keys: Sequence[str]
) -> list[Row]:
    """Return the rows of some members; trouble in one is its row and no one else's.

    Rows of members that an interruption (Ctrl-C) left without an end are pending.

    Parameters
    ----------
    numbers, keys : of the members; keys go into the rows
    """
    rows = {number: Row(key) for number, key in zip(numbers, keys, strict=True)}
    groups: dict[str, list[_Ready]] = {}
    for number in numbers:
        mechanism = plan.mechanism_of(number)
        solver = mechanism["solver"]
        try:
            kept = {*plan.signals, *plan.histories}
            ready = _Ready(number, solver, prepare(mechanism, packages.of(number), kept))
        except Exception as error:
            rows[number] = _failed(rows[number], error)
            continue
        if ready.prepared.refused is not None:
            rows[number] = _told(plan, ready, rows[number], ready.prepared.refused, 0.0)
            continue
        groups.setdefault(structure(ready.prepared.model) + repr(solver), []).append(ready)
    for group in groups.values():
        rows |= _group(plan, group, rows)
        if any(not rows[ready.number].done for ready in group):
            break
    return [rows[number] for number in numbers]


@dataclass(frozen=True)
class _Ready:
    """A member that can be integrated."""

    number: int
    solver: dict[str, Any]  # its `[solver]`
    prepared: Prepared

    @property
    def times(self) -> Array:
        """Output times (n_t,) [s]."""
        return output_times(self.solver["t_end"], self.solver["output_step"])


def _group(plan: Plan, group: list[_Ready], rows: dict[int, Row]) -> dict[int, Row]:
    """Return the rows of members of one structure with the same settings."""
    first = group[0]
    begin = time.perf_counter()
    solutions = integrate_members(
        [ready.prepared.model for ready in group],
        [ready.prepared.y0 for ready in group],
        first.solver,
        first.times,
        [ready.prepared.watch for ready in group],
        first.prepared.treatment,
    )
    each = (time.perf_counter() - begin) / len(group)
    found = {}
    # shorter than the group where the user interrupted
    for ready, solution in zip(group, solutions, strict=False):
        row = rows[ready.number]
        if isinstance(solution, Exception):
            found[ready.number] = _failed(row, solution)
        elif solution.status != INTERRUPTED:
            try:
                found[ready.number] = _told(plan, ready, row, solution, each)
            except Exception as error:
                found[ready.number] = _failed(row, error)
    return found


def _failed(row: Row, error: Exception) -> Row:
    """Return the row of a member that ended in an error."""
    message = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, InputError | PackageError):
        code = "package" if isinstance(error, PackageError) else "input"
        return replace(row, status=FAILED, message=message, code=code)
    message = f"{type(error).__name__}: {message}"
    return replace(
        row,
        status=FAILED,
        message=message,
        code="defect",
        defect="".join(traceback.format_exception(error)),
    )


def _told(plan: Plan, ready: _Ready, row: Row, solution: Solution, seconds: float) -> Row:
    """Return the row of a member from its solution."""
    prepared = ready.prepared
    solution = prepared.explained(solution)
    model, t, y = prepared.model, solution.t, solution.y
    recording = Recording(model, t, y)
    names = dict.fromkeys((*plan.signals, *plan.histories))
    series = {
        name: Signal(name, sensor.unit, sensor.description, sensor.values(recording))
        for name, sensor in ((name, prepared.measured[name]) for name in names)
    }
    times = ready.times
    kept = int(np.searchsorted(times, t[-1], side="right"))
    histories = {}
    for name in plan.histories:
        histories[name] = np.full(times.size, np.nan)
        histories[name][:kept] = series[name].values[:kept]
    checks = _checks(prepared, solution)
    doubts = [item["code"] for item in prepared.noticed()]
    doubts += [SPIN_CODE for _ in prepared.spin.warnings]
    doubts += [item["code"] for item in findings.of_checks(checks)]
    doubts += [item["code"] for item in findings.of_motion(prepared.built, y)]
    if solution.status != FINISHED and solution.code != SPIN_CODE:
        doubts.append(f"run-{solution.status}")
    counters = vars(solution.counters)
    return replace(
        row,
        status=solution.status,
        message="" if solution.status == FINISHED else solution.message,
        code=solution.code,
        t_end=float(t[-1]),
        signals={name: signal_summary(series[name], t) for name in plan.signals},
        histories=histories,
        checks={name: checks[name] for name in CHECKS},
        cost={name: float(counters.get(name, seconds)) for name in COST},
        warnings=tuple(dict.fromkeys(doubts)),
    )


def _checks(prepared: Prepared, solution: Solution) -> dict[str, Any]:
    """Return what `findings.of_checks` judges, from some of the output times."""
    model = prepared.model
    some = _some(solution.t.size, JUDGED_TIMES)
    t, y = solution.t[some], solution.y[some]
    past = recover.history(model, t, y)
    few = _some(t.size, BALANCED_TIMES)
    balance = momentum_balance(model, t[few], y[few])
    return {
        "constraint_position_max": float(past.position_violation.max()),
        "constraint_rotation_max": float(past.rotation_violation.max()),
        "constraint_velocity_max": float(past.velocity_violation.max()),
        "energy_drift_relative": float(np.abs(relative_balance(past.energies)).max()),
        "drive_work": float(past.energies["drive_work"][-1]),
        "momentum_balance": max(balance.linear, balance.angular),
        "degrees_of_freedom": degrees_of_freedom(model, solution.y[0]),
    }


def _some(count: int, most: int) -> np.ndarray:
    return np.unique(np.linspace(0, count - 1, most).astype(int))
