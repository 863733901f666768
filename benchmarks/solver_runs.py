"""Run a problem as `plymotion run` does, measure processor time and error."""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from solver_methods import Method
from solver_problems import Problem

from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.math.arrays import Array
from plymotion.solver.results import RunResult
from plymotion.solver.run.execution import execute
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.run.preparation import output_times, prepare

REFERENCE = Method("reference", "rk8", "projection", (1e-10,))


@dataclass(frozen=True)
class Point:
    """One run of one method."""

    label: str
    tolerance: float  # rtol; of a peer its step [s]
    status: str
    error: float  # largest over the output times [m]
    cpu_s: float  # of the whole run: build, steps, monitors, signals, checks
    steps: int
    evaluations: int
    bare_s: float = np.nan  # of the steps alone, without monitors; with the same output times
    phases: dict[str, float] = field(default_factory=dict)  # of cpu_s, as summary.json has them


class OverBudget(Exception):
    """A run took more processor time than was set aside for it."""


def solve(spec: RunSpec, budget_s: float = np.inf) -> tuple[RunResult, dict[str, Any], float]:
    """Result, summary and processor time [s] of a run, by the function of `plymotion run`.

    Raises OverBudget after `budget_s` of processor time.
    """
    begin = time.process_time()
    with _limit(budget_s):
        result, summary = execute(spec, progress=False)
    return result, summary, time.process_time() - begin


@contextmanager
def _limit(budget_s: float) -> Iterator[None]:
    """End what runs as Ctrl-C does, by a timer."""
    if not np.isfinite(budget_s):
        yield
        return
    fired = []

    def over(*_: object) -> None:
        fired.append(True)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, budget_s)
    try:
        yield
    except KeyboardInterrupt:
        if not fired:
            raise
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    if fired:  # a run that is interrupted while it steps returns as usual
        raise OverBudget


def bare(spec: RunSpec) -> float:
    """Processor time [s] of the integration alone: no building, monitors, signals or checks."""
    prepared = prepare(spec.mechanism, spec.packages)
    solver = spec.mechanism.solver
    times = output_times(solver.t_end, solver.output_step)
    begin = time.process_time()
    integrate(make_integrator(prepared.model, prepared.y0, solver, prepared.treatment), times)
    return time.process_time() - begin


def reference(problem: Problem, rtol: float = 1e-10) -> Array:
    """Positions (k, 3) of the probe, converged [m]."""
    result, summary, _ = solve(problem.with_solver(REFERENCE, rtol))
    if summary["status"] != "finished":
        raise SystemExit(f"{problem.name}: no reference: {summary['message']}")
    return problem.places(result)


def largest(places: Array, exact: Array) -> float:
    """Largest distance over the output times [m]."""
    return float(np.linalg.norm(places - exact, axis=1).max())


def point(
    problem: Problem,
    method: Method,
    rtol: float,
    exact: Array,
    budget_s: float = np.inf,
    *,
    with_bare: bool = False,
) -> Point:
    """Run once and compare with the converged positions."""
    spec = problem.with_solver(method, rtol)
    try:
        result, summary, cpu = solve(spec, budget_s)
    except OverBudget:
        return Point(method.label, rtol, "budget", np.nan, budget_s, 0, 0)
    status, cost = summary["status"], summary["cost"]
    done = status == "finished"
    error = largest(problem.places(result), exact) if done else np.nan
    loop = bare(spec) if done and with_bare else np.nan
    return Point(
        method.label,
        rtol,
        status,
        error,
        cpu,
        cost["steps"],
        cost["evaluations"],
        loop,
        cost["seconds"],
    )


def warm_up(problem: Problem, methods: list[Method]) -> None:
    """Load or compile what a method needs, so that no measured run does."""
    for method in methods:
        solve(problem.with_solver(method, method.rtols[0], t_end=2e-3, output_step=1e-3))


def shorter(point: Point) -> dict[str, Any]:
    """The point as a row of a table, without its phases."""
    row = vars(replace(point, phases={}))
    return {k: v for k, v in row.items() if k != "phases"}
