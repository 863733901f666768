"""Time per link and step of chains of flexible links, ours and Exudyn's, h = 1 ms."""

import statistics
import time
from typing import Any

import solver_exudyn
from solver_exudyn import FULL, MODIFIED
from solver_methods import CHAIN_METHODS, Method, available
from solver_problems import Problem, chain
from solver_runs import limit, prepared
from tqdm import tqdm

from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic import integrate

LINKS = (8, 16, 32, 64, 128, 256)
EXUDYN_LINKS = (8, 16, 32, 64, 128)
STEP = 1e-3  # [s]
STEPS = 50


def fixed_steps(problem: Problem, method: Method, budget_s: float) -> tuple[int, float, str]:
    """Steps done at STEP, the processor time they took [s], and how it ended."""
    model, solver = prepared(problem, method, method.rtols[0])
    integrator = make_integrator(model, problem.y0, solver, fixed_step=STEP)
    begin = time.process_time()
    solution = integrate(integrator, [problem.t_end], limit(integrator, begin + budget_s))
    cpu = time.process_time() - begin
    return solution.counters.steps, cpu, solution.code or solution.status


def measure(rounds: int, budget_s: float) -> dict[str, Any]:
    """Microseconds per link and step by number of links; the best method, and every one."""
    methods = available(CHAIN_METHODS)
    ours: dict[str, dict[int, list[float]]] = {m.label: {} for m in methods}
    theirs: dict[str, dict[int, list[float]]] = {FULL: {}, MODIFIED: {}}
    tried: dict[str, dict[int, str]] = {m.label: {} for m in methods}
    for method in methods:  # compiles
        fixed_steps(chain(2, 2 * STEP), method, budget_s)
    for n in tqdm(LINKS, desc="chain", unit="length"):
        problem = chain(n, STEPS * STEP)
        for _ in range(rounds):
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
        "status": {label: {str(n): s for n, s in row.items()} for label, row in tried.items()},
        "step_s": STEP,
        "steps": STEPS,
        "longest_that_fits_s": budget_s,
    }


def _hopeless(status: dict[int, str]) -> bool:
    """Whether a shorter chain did not get through in the time set aside."""
    return any(s not in ("finished", "") for s in status.values())


def _medians(found: dict[int, list[float]]) -> dict[str, float]:
    return {str(n): statistics.median(values) for n, values in found.items()}
