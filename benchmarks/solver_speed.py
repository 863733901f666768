"""The solver beside Exudyn on the same reduced bodies: `make bench`.

PYTHONPATH=.:benchmarks .venv/bin/python benchmarks/solver_speed.py [JSON] [--write docs/speed.md]

Writes build/benchmarks/solver.json. Processor time of one process with one thread; every number
is the median of interleaved runs: ours and theirs in turn, round after round.
"""

import argparse
import json
import statistics
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import ensemble
import numpy as np
import solver_exudyn
from solver_chain import measure as measure_chain
from solver_curves import cpu_at, ratios
from solver_exudyn import FULL, MODIFIED
from solver_methods import INTEGRATOR_METHODS, available
from solver_problems import double_pendulum
from solver_runs import Point, largest, point, reference, warm_up
from solver_text import write_tables
from tqdm import tqdm

from plymotion.solver.package.common.container import temporary_sibling

STEPS = (500, 1000, 2000, 5000, 10000, 20000, 50000, 70000)
LONG = 3.0  # [s]; longer runs scatter little and are not repeated
TARGETS = ("1e-4", "2e-6", "1e-7")


def measure_double_pendulum(rounds: int, budget_s: float) -> dict[str, Any]:
    """Error against processor time of every integrator and of Exudyn."""
    problem = double_pendulum()
    methods = available(INTEGRATOR_METHODS)
    warm_up(problem, methods)
    exact = reference(problem)
    theirs: dict[str, dict[int, list[Point]]] = {k: defaultdict(list) for k in (FULL, MODIFIED)}
    ours: dict[str, dict[float, list[Point]]] = {m.label: defaultdict(list) for m in methods}
    longest = max(len(STEPS), *(len(m.rtols) for m in methods))
    bar = tqdm(total=rounds * longest, desc="double pendulum", unit="row")
    for _ in range(rounds):
        for k in range(longest):
            for method in methods:
                if k < len(method.rtols):
                    rtol = method.rtols[k]
                    done = ours[method.label][rtol]
                    if not done and any(_over(points) for points in ours[method.label].values()):
                        continue  # what a looser tolerance could not do in time
                    if not done or (done[0].status == "finished" and done[0].cpu_s < LONG):
                        done.append(point(problem, method, rtol, exact, budget_s))
            if k < len(STEPS):
                for newton, found in theirs.items():
                    tip, cpu = solver_exudyn.double_pendulum(STEPS[k], newton)
                    error = largest(tip, exact)
                    h = problem.t_end / STEPS[k]
                    found[STEPS[k]].append(Point(newton, h, "finished", error, cpu, STEPS[k], 0))
            bar.update()
    bar.close()
    peers = {newton: _medians(found) for newton, found in theirs.items()}
    own = {label: _medians(found) for label, found in ours.items()}
    pairs = {label: _pairs(rows) for label, rows in own.items()}
    return {
        "exudyn": _pairs(peers[FULL]),
        "exudyn_modified_newton": _pairs(peers[MODIFIED]),
        "plymotion": pairs,
        "ratio_at": ratios(pairs, _pairs(peers[FULL]), TARGETS),
        "ratio_at_modified_newton": ratios(pairs, _pairs(peers[MODIFIED]), TARGETS),
        "best": {
            target: min(pairs, key=lambda label: cpu_at(pairs[label], float(target)))
            for target in TARGETS
        },
        "runs": [vars(p) for rows in [*peers.values(), *own.values()] for p in rows],
        "limits": exudyn_limits(exact),
    }


def _over(points: list[Point]) -> bool:
    return any(p.status == "budget" for p in points)


def exudyn_limits(exact: np.ndarray) -> dict[str, float]:
    """Distance between Exudyn's converged tip and ours, by how its gravity is written [m].

    The limit is extrapolated from 25 000 and 50 000 steps, second order.
    """
    weightless = reference(double_pendulum(gravity=0.0))
    found = {}
    for name, gravity, g, ours in (
        ("gravity on the nodes", "nodes", 9.81, exact),
        ("gravity on the body", "body", 9.81, exact),
        ("no gravity", "nodes", 0.0, weightless),
    ):
        coarse, fine = (
            solver_exudyn.double_pendulum(n, MODIFIED, gravity=gravity, g=g)[0]
            for n in (25000, 50000)
        )
        found[name] = largest(fine + (fine - coarse) / 3.0, ours)
    return found


def _medians(found: dict[Any, list[Point]]) -> list[Point]:
    """One point a setting, its time the median over the rounds."""
    rows = []
    for points in filter(None, found.values()):
        cpu = statistics.median(p.cpu_s for p in points)
        rows.append(Point(**(vars(points[-1]) | {"cpu_s": cpu})))
    return rows


def _pairs(rows: list[Point]) -> list[list[float]]:
    return [[p.error, p.cpu_s] for p in rows if p.status == "finished" and np.isfinite(p.error)]


def measure_ensemble() -> dict[str, Any]:
    """512 double pendulums by the sweep engine over single runs in plain NumPy."""
    return dict(ensemble.measure())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("json", nargs="?", type=Path, default=Path("build/benchmarks/solver.json"))
    parser.add_argument("--rounds", type=int, default=3, help="interleaved runs of each setting")
    parser.add_argument("--budget", type=float, default=8.0, help="longest run of ours [s]")
    parser.add_argument("--chain-budget", type=float, default=8.0, help="longest chain [s]")
    parser.add_argument("--only", choices=("double_pendulum", "chain", "ensemble"))
    parser.add_argument("--write", type=Path, help="document whose tables are renewed")
    arguments = parser.parse_args()
    parts = {
        "double_pendulum": lambda: measure_double_pendulum(arguments.rounds, arguments.budget),
        "chain": lambda: measure_chain(arguments.rounds, arguments.chain_budget),
        "ensemble": measure_ensemble,
    }
    found: dict[str, Any] = {}
    if arguments.only and arguments.json.exists():
        found = json.loads(arguments.json.read_text(encoding="utf-8"))
    begin = time.perf_counter()
    if arguments.only != "ensemble":
        solver_exudyn.exudyn()  # missing? say so before anything is measured
    for name, measure in parts.items():
        if arguments.only in (None, name):
            found[name] = measure()
    arguments.json.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(arguments.json) as temporary:
        temporary.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(f"{arguments.json}: {time.perf_counter() - begin:.0f} s")
    if "double_pendulum" in found:
        print("ratio_at", json.dumps(found["double_pendulum"]["ratio_at"]))
    if arguments.write is not None:
        write_tables(found, arguments.write)


if __name__ == "__main__":
    main()
