"""The solver beside Exudyn on the same reduced bodies: `make bench`.

PYTHONPATH=.:benchmarks .venv/bin/python benchmarks/solver_speed.py [JSON] [--write docs/speed.md]

Writes build/benchmarks/solver.json. Our runs are made by the function or the command that a user
calls, with the settings of a case but for integrator and rtol. Processor time with one thread;
every number is the median of interleaved runs: ours and theirs in turn, round after round.
"""

import argparse
import json
import os
import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import ensemble
import numpy as np
import solver_chain
import solver_exudyn
import solver_limit
import solver_memory
from exudyn_plane import FULL, MODIFIED
from solver_curves import cpu_at, ratios
from solver_methods import DEFAULT, INTEGRATOR_METHODS, available
from solver_problems import Problem, double_pendulum
from solver_runs import Point, largest, point, reference, solve, warm_up
from solver_text import write_tables
from solver_time import SHARES, deadline, rounds_until
from tqdm import tqdm

from plymotion.solver.package.common.files import temporary_sibling

STEPS = (500, 1000, 2000, 5000, 10000, 20000, 50000, 70000)
LONG = 3.0  # [s]; longer runs scatter little and are not repeated
REPEATED = 25
TARGETS = ("1e-4", "2e-6", "1e-7")


def measure_double_pendulum(rounds: int, budget_s: float, end: float) -> dict[str, Any]:
    """Error against processor time of every integrator and of Exudyn."""
    problem = double_pendulum()
    methods = available(INTEGRATOR_METHODS)
    warm_up(problem, methods)
    exact = reference(problem)
    theirs: dict[str, dict[int, list[Point]]] = {k: defaultdict(list) for k in (FULL, MODIFIED)}
    ours: dict[str, dict[float, list[Point]]] = {m.label: defaultdict(list) for m in methods}
    longest = max(len(STEPS), *(len(m.rtols) for m in methods))
    bar = tqdm(total=rounds * longest, desc="double pendulum", unit="row")
    for _ in rounds_until(rounds, end):
        for k in range(longest):
            for method in methods:
                if k < len(method.rtols):
                    rtol = method.rtols[k]
                    done = ours[method.label][rtol]
                    if not done and any(_over(points) for points in ours[method.label].values()):
                        continue  # what a looser tolerance could not do in time
                    if not done or (done[0].status == "finished" and done[0].cpu_s < LONG):
                        done.append(point(problem, method, rtol, exact, budget_s, with_bare=True))
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
    loops = {label: [[p.error, p.bare_s] for p in rows] for label, rows in own.items()}
    return {
        "exudyn": _pairs(peers[FULL]),
        "exudyn_modified_newton": _pairs(peers[MODIFIED]),
        "plymotion": pairs,
        "bare": {
            label: [row for row in rows if np.isfinite(row).all()] for label, rows in loops.items()
        },
        "default": phases(problem, own[DEFAULT.label], _pairs(peers[MODIFIED])),
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
        loop = statistics.median(p.bare_s for p in points)
        names = points[-1].phases
        phases = {k: statistics.median(p.phases.get(k, 0.0) for p in points) for k in names}
        rows.append(replace(points[-1], cpu_s=cpu, bare_s=loop, phases=phases))
    return rows


def phases(problem: Problem, rows: list[Point], theirs: list[list[float]]) -> list[dict[str, Any]]:
    """The cheapest run of the default integrator below each error, phase by phase.

    Means of REPEATED runs: the clock of some systems counts in steps of 4 ms.
    """
    found = []
    for target in TARGETS:
        fit = [p for p in rows if p.status == "finished" and p.error < float(target)]
        if not fit:
            continue
        best = min(fit, key=lambda p: p.cpu_s)
        spec = problem.with_solver(DEFAULT, best.tolerance)
        runs = [solve(spec) for _ in range(REPEATED)]
        seconds = [summary["cost"]["seconds"] for _, summary, _ in runs]
        row = {
            "cpu_s": statistics.fmean(cpu for _, _, cpu in runs),
            "phases": {k: statistics.fmean(s[k] for s in seconds) for k in seconds[0]},
            "exudyn_s": cpu_at(theirs, float(target)),
        }
        found.append({"target": target, **vars(best), **row})
    return found


def _pairs(rows: list[Point]) -> list[list[float]]:
    return [[p.error, p.cpu_s] for p in rows if p.status == "finished" and np.isfinite(p.error)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("json", nargs="?", type=Path, default=Path("build/benchmarks/solver.json"))
    parser.add_argument("--rounds", type=int, default=3, help="interleaved runs of each setting")
    parser.add_argument("--budget", type=float, default=4.0, help="longest run of ours [s]")
    parser.add_argument("--chain-budget", type=float, default=8.0, help="longest chain [s]")
    parser.add_argument("--links", type=int, default=256, help="chain whose memory is measured")
    parser.add_argument("--only", choices=tuple(SHARES))
    parser.add_argument("--minutes", type=float, default=15.0, help="after which none is repeated")
    parser.add_argument("--write", type=Path, help="document whose tables are renewed")
    arguments = parser.parse_args()
    rounds = arguments.rounds
    # By part, the measurement: a function of when it stops to repeat its runs.
    measures: dict[str, Callable[[float], Any]] = {
        "double_pendulum": lambda end: measure_double_pendulum(rounds, arguments.budget, end),
        "ensemble": lambda _: ensemble.measure(),
        "chain": lambda end: solver_chain.measure(rounds, arguments.chain_budget, end),
        "limit": lambda _: solver_limit.measure(),
        "memory": lambda _: solver_memory.measure(arguments.links),
    }
    found: dict[str, Any] = {}
    if arguments.only and arguments.json.exists():
        found = json.loads(arguments.json.read_text(encoding="utf-8"))
    begin = time.perf_counter()
    if arguments.only not in ("ensemble", "memory", "limit"):
        solver_exudyn.exudyn()  # missing? say so before anything is measured
    parts = [name for name in measures if arguments.only in (None, name)]
    minutes = arguments.minutes * sum(SHARES[name] for name in parts)
    print(f"about {minutes:.0f} minutes on two quiet cores: {', '.join(parts)}", flush=True)
    for k, name in enumerate(parts, start=1):
        load, start = os.getloadavg()[0], time.perf_counter()
        found[name] = measures[name](deadline(name, arguments.minutes))
        # other processes disturb a measurement: how many there were, before and after
        found.setdefault("load", {})[name] = [load, os.getloadavg()[0]]
        # after each part: what comes later may fail, or be interrupted
        _write(found, arguments.json)
        if arguments.write is not None:
            write_tables({name: found[name], "load": found["load"]}, arguments.write)
        spent = time.perf_counter() - start
        print(f"{k} of {len(parts)}, {name}: {spent:.0f} s", flush=True)
    print(f"{arguments.json}: {time.perf_counter() - begin:.0f} s")
    if "double_pendulum" in found:
        print("ratio_at", json.dumps(found["double_pendulum"]["ratio_at"]))


def _write(found: dict[str, Any], file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(file) as temporary:
        temporary.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
