"""Run a problem with a method, in processor time, and measure its error."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from solver_methods import Method
from solver_problems import Problem

from plymotion.solver.dynamics.constraints.treatment import treated
from plymotion.solver.dynamics.model import Model
from plymotion.solver.inputs.case.solver import Solver
from plymotion.solver.integrators.choice import make_integrator, treatment_of
from plymotion.solver.integrators.generic import Integrator, Solution, StopRequest, integrate
from plymotion.solver.math.arrays import Array
from plymotion.solver.run.execution import output_times

REFERENCE = Method("reference", "rk8", "projection", (1e-10,))
Follow = Callable[[Integrator], "StopRequest | None"]


@dataclass(frozen=True)
class Point:
    """One run of one method."""

    label: str
    tolerance: float  # rtol; of a peer its step [s]
    status: str
    error: float  # largest over the output times [m]
    cpu_s: float
    steps: int
    evaluations: int


def solver_options(method: Method, rtol: float, problem: Problem) -> Solver:
    """`[solver]` of a case for a method."""
    table = {
        "integrator": method.integrator,
        "constraints": method.constraints,
        "t_end": problem.t_end,
        "output_step": problem.output_step,
        "rtol": rtol,
        "atol_position": 1e-2 * rtol,
        "atol_velocity": rtol,
    }
    return Solver.model_validate(table | method.options)


def prepared(problem: Problem, method: Method, rtol: float) -> tuple[Model, Solver]:
    """Model ready for the method's treatment of constraints, and `[solver]`."""
    solver = solver_options(method, rtol, problem)
    return treated(problem.model, treatment_of(solver)), solver


def solve(
    problem: Problem,
    method: Method,
    rtol: float,
    *,
    budget_s: float = np.inf,
) -> tuple[Solution, float]:
    """Solution at the output times and the processor time of making it [s].

    A run that takes more than `budget_s` is stopped, unless its loop is compiled whole.
    """
    model, solver = prepared(problem, method, rtol)
    times = output_times(problem.t_end, problem.output_step)
    begin = time.process_time()
    integrator = make_integrator(model, problem.y0, solver)
    solution = integrate(integrator, times, limit(integrator, begin + budget_s))
    return solution, time.process_time() - begin


def limit(integrator: Integrator, last: float) -> Follow | None:
    """Watch that ends a run at processor time `last` [s].

    None for loops that take many steps in one call: they are fast, and a look at every step would
    cost them as much again as the step.
    """
    if integrator.strides or not np.isfinite(last):
        return None

    def follow(one: Integrator) -> StopRequest | None:
        if time.process_time() > last:
            return StopRequest(one.t, "out of the time set aside for it", "budget")
        return None

    return follow


def reference(problem: Problem, rtol: float = 1e-10) -> Array:
    """Positions (k, 3) of the probe, converged [m]."""
    solution, _ = solve(problem, REFERENCE, rtol)
    if solution.status != "finished":
        raise SystemExit(f"{problem.name}: no reference: {solution.message}")
    return problem.places(solution.y)


def largest(places: Array, exact: Array) -> float:
    """Largest distance over the output times [m]."""
    return float(np.linalg.norm(places - exact, axis=1).max())


def point(
    problem: Problem, method: Method, rtol: float, exact: Array, budget_s: float = np.inf
) -> Point:
    """Run once and compare with the converged positions."""
    solution, cpu = solve(problem, method, rtol, budget_s=budget_s)
    done = solution.status == "finished"
    error = largest(problem.places(solution.y), exact) if done else np.nan
    c = solution.counters
    status = solution.code or solution.status
    return Point(method.label, rtol, status, error, cpu, c.steps, c.evaluations)


def warm_up(problem: Problem, methods: list[Method]) -> None:
    """Compile what a method needs, so that no measured run does."""
    from dataclasses import replace

    short = replace(problem, t_end=2e-3, output_step=1e-3)
    for method in methods:
        solve(short, method, method.rtols[0])
