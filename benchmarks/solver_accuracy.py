"""Error against processor time of integrators and treatments of constraints, as CSV.

PYTHONPATH=.:benchmarks .venv/bin/python benchmarks/solver_accuracy.py integrators|treatments CSV

One run each: the charts span four decades of time. Exudyn is drawn if `make bench` has fetched it.
"""

import argparse
import sys
from pathlib import Path

import solver_exudyn
from solver_csv import write
from solver_methods import INTEGRATOR_METHODS, TREATMENT_METHODS, Method, available
from solver_problems import Problem, actuated_beam, chain, double_pendulum
from solver_runs import Point, largest, point, reference, shorter, warm_up
from tqdm import tqdm

from plymotion.solver.math.arrays import Array

CHAIN = 4
CHAIN_END = 0.5  # [s]
STEPS = (500, 1000, 2000, 5000, 10000, 20000, 50000, 70000)
METHODS = {"integrators": INTEGRATOR_METHODS, "treatments": TREATMENT_METHODS}


def peer(problem: Problem, exact: Array) -> list[Point]:
    """Exudyn on the same mechanism; none where there is no model of it."""
    makers = {
        "double-pendulum": lambda n: solver_exudyn.double_pendulum(n, solver_exudyn.MODIFIED),
        f"chain-{CHAIN}": lambda n: solver_exudyn.chain(
            CHAIN, n, problem.t_end / n, solver_exudyn.MODIFIED
        ),
    }
    if problem.name not in makers:
        return []
    rows = []
    for steps in STEPS:
        tip, cpu = makers[problem.name](steps)
        error = largest(tip, exact)
        rows.append(Point("Exudyn", problem.t_end / steps, "finished", error, cpu, steps, 0))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=tuple(METHODS))
    parser.add_argument("csv", type=Path)
    parser.add_argument("--budget", type=float, default=5.0, help="longest run [s]")
    arguments = parser.parse_args()
    methods: list[Method] = available(METHODS[arguments.kind])
    problems = [double_pendulum(), actuated_beam(), chain(CHAIN, CHAIN_END)]
    rows: list[dict[str, object]] = []
    for problem in problems:
        warm_up(problem, methods)
        exact = reference(problem)
        found: list[Point] = []
        for method in tqdm(methods, desc=problem.name):
            for rtol in method.rtols:
                found.append(point(problem, method, rtol, exact, arguments.budget))
                if found[-1].status == "budget":
                    break
        if arguments.kind == "integrators":
            try:
                found += peer(problem, exact)
            except SystemExit as missing:
                print(f"note: {missing}", file=sys.stderr)
        rows += [{"problem": problem.name, "title": problem.title, **shorter(p)} for p in found]
    write(arguments.csv, rows)


if __name__ == "__main__":
    main()
