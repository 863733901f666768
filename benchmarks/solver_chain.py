"""Time per link and step of chains of flexible links, ours and Exudyn's, h = 1 ms.

And whole runs of the same chains by the function of `plymotion run`, with its own steps.
"""

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import solver_exudyn
from exudyn_plane import FULL, MODIFIED
from solver_methods import CHAIN_METHODS, DEFAULT, Method, available
from solver_problems import Problem, chain
from solver_runs import solve
from solver_time import rounds_until
from tqdm import tqdm

from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.base import Integrator
from plymotion.solver.integrators.generic.drive import StopRequest, integrate
from plymotion.solver.integrators.table import treatment_of
from plymotion.solver.mechanism.assembly import treated
from plymotion.solver.mechanism.build import build

LINKS = (8, 16, 32, 64, 128, 256, 512, 1024)
WHOLE_LINKS = LINKS
EXUDYN_LINKS = (8, 16, 32, 64, 128)
STEP = 1e-3  # [s]
STEPS = 50
RTOL = 1e-6  # of the whole runs
LONG = 5.0  # [s]; longer whole runs are not repeated


def fixed_steps(problem: Problem, method: Method, budget_s: float) -> tuple[int, float, str]:
    """Steps done at STEP, the processor time they took [s], and how it ended. No monitors."""
    spec = problem.with_solver(method, method.rtols[0])
    solver = spec.mechanism.solver
    built = build(spec.mechanism, spec.packages)
    model = treated(built.model, treatment_of(solver))
    # hangs in its joints, at rest: consistent as it is
    y0 = np.concatenate([built.start.positions, np.zeros(model.n_vel + 1)])
    integrator = make_integrator(model, y0, solver, fixed_step=STEP)
    begin = time.process_time()
    solution = integrate(integrator, [problem.t_end], limit(integrator, begin + budget_s))
    cpu = time.process_time() - begin
    return solution.counters.steps, cpu, solution.code or solution.status


def limit(integrator: Integrator, last: float) -> Callable[[Integrator], StopRequest | None] | None:
    """End a run at processor time `last` [s]; None for loops that take many steps in one call."""
    if integrator.strides:
        return None

    def follow(one: Integrator) -> StopRequest | None:
        if time.process_time() > last:
            return StopRequest(one.t, "out of the time set aside for it", "budget")
        return None

    return follow


def measure(rounds: int, budget_s: float, end: float) -> dict[str, Any]:
    """Microseconds per link and step by number of links; the best method, and every one."""
    methods = available(CHAIN_METHODS)
    ours: dict[str, dict[int, list[float]]] = {m.label: {} for m in methods}
    theirs: dict[str, dict[int, list[float]]] = {FULL: {}, MODIFIED: {}}
    tried: dict[str, dict[int, str]] = {m.label: {} for m in methods}
    for method in methods:  # compiles
        fixed_steps(chain(2, 2 * STEP), method, budget_s)
    for n in tqdm(LINKS, desc="chain", unit="length"):
        problem = chain(n, STEPS * STEP)
        for _ in rounds_until(rounds, end):
            for method in methods:
                if _hopeless(tried[method.label]):
                    continue
                steps, cpu, status = fixed_steps(problem, method, budget_s)
                tried[method.label][n] = "budget" if cpu > budget_s else status
                if status in ("finished", "budget") and steps >= 3:
                    ours[method.label].setdefault(n, []).append(1e6 * cpu / (steps * n))
            if n in EXUDYN_LINKS:
                for newton, found in theirs.items():
                    _, cpu = solver_exudyn.chain(n, STEPS, STEP, newton)
                    found.setdefault(n, []).append(1e6 * cpu / (STEPS * n))
    every = {label: _medians(found) for label, found in ours.items()}
    best = min(every, key=lambda label: (-len(every[label]), sum(every[label].values())))
    return {
        "us_per_link_step": every[best],
        "exudyn_us_per_link_step": _medians(theirs[FULL]),
        "exudyn_modified_newton_us_per_link_step": _medians(theirs[MODIFIED]),
        "method": best,
        "every_us_per_link_step": every,
        "growth": {
            label: row[str(LINKS[-1])] / row["8"]
            for label, row in every.items()
            if str(LINKS[-1]) in row
        },
        "whole": whole(rounds, end),
        "status": {label: {str(n): s for n, s in row.items()} for label, row in tried.items()},
        "step_s": STEP,
        "steps": STEPS,
        "longest_that_fits_s": budget_s,
    }


def whole(rounds: int, end: float) -> list[dict[str, Any]]:
    """Whole runs with monitors, signals and checks, by number of links; medians of the rounds.

    Times per link: of the steps with and without monitors, us per step; of the rest, ms.
    """
    rows = []
    solve(chain(2, STEPS * STEP).with_solver(DEFAULT, RTOL))
    for n in tqdm(WHOLE_LINKS, desc="whole runs", unit="length"):
        spec = chain(n, STEPS * STEP).with_solver(DEFAULT, RTOL)
        found: list[dict[str, float]] = []
        steps, total = 0, 0.0
        for _ in rounds_until(rounds, end):
            _, summary, total = solve(spec)
            cost = summary["cost"]
            steps = cost["steps"]
            found.append({**cost["seconds"], "total": total})
            if total > LONG:
                break
        seconds = {k: statistics.median(f[k] for f in found) for k in found[0]}
        rows.append(
            {
                "links": n,
                "steps": steps,
                "us_integrate": 1e6 * seconds["integrate"] / (steps * n),
                "us_watched": 1e6 * (seconds["integrate"] + seconds["monitors"]) / (steps * n),
                "ms_build": 1e3 * seconds["build"] / n,
                "ms_recover": 1e3 * seconds["recover"] / n,
                "ms_total": 1e3 * seconds["total"] / n,
            }
        )
    return rows


def _hopeless(status: dict[int, str]) -> bool:
    """Whether a shorter chain did not get through in the time set aside."""
    return any(s not in ("finished", "") for s in status.values())


def _medians(found: dict[int, list[float]]) -> dict[str, float]:
    return {str(n): statistics.median(values) for n, values in found.items()}
