"""512 double pendulums (mass at the tip by speed), 1 s each, by the command `plymotion sweep`.

PYTHONPATH=.:benchmarks .venv/bin/python benchmarks/ensemble.py [--jobs N]

Processor time of the command and its workers: start, packages, models, integration, monitors,
signals, checks, tables and figures. The tolerance is the largest at which all of some members,
spread over the sweep, have a tip error below 1e-4 m; the reference is rk8 at rtol 1e-10.
"""

import argparse
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from processes import cost
from solver_methods import DEFAULT, Method
from solver_runs import REFERENCE, solve

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.results import RunResult
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.studies.sweep.sweep_members import read_sweep_spec

CASE = "double-pendulum"
SWEEP = "masses"
T_END = 1.0  # [s] of motion
GOAL = 1e-4  # [m]
PROBED = 9  # members


def measure(jobs: int | None = None) -> dict[str, Any]:
    """Time of the sweep by member, tolerance, errors of the probed members."""
    jobs = jobs or os.cpu_count() or 1
    with tempfile.TemporaryDirectory() as folder:
        file = _checked(Path(folder))
        rtol, errors = _tolerance(file)
        _set(file, _solver(DEFAULT, rtol))
        out = Path(folder) / "out"
        command = ["-m", "plymotion", "sweep", str(file), "--out", str(out), "--quiet"]
        used = cost([*command, "--jobs", str(jobs)], allowed=(0, 3))
        with h5py.File(out / "sweep.h5") as kept:
            status = [s.decode() for s in kept["members/status"][()]]
    members = len(status)
    return {
        "case": f"{CASE}, sweep {SWEEP}, {T_END:g} s, {DEFAULT.label}, rtol {rtol:g}",
        "members": members,
        "finished": status.count("finished"),
        "probed_error_m": max(errors),
        "jobs": jobs,
        "wall_s": used.wall_s,
        "cpu_s": used.cpu_s,
        "ms_per_member_and_core": 1e3 * used.cpu_s / members,
    }


def _checked(folder: Path) -> Path:
    """Check the case into a folder, with the packages of the repository; its sweep file."""
    case = load_case(Path("cases") / CASE / "case.toml")
    write_case(case, folder, Path("tests/packages") / CASE)
    return folder / "sweeps" / f"{SWEEP}.json"


def _solver(method: Method, rtol: float) -> dict[str, Any]:
    return {
        "t_end": T_END,
        "output_step": 1e-3,
        "integrator": method.integrator,
        "constraints": method.constraints,
        "rtol": rtol,
    }


def _set(file: Path, solver: dict[str, Any]) -> None:
    table = json.loads(file.read_text(encoding="utf-8"))
    table["mechanism"]["solver"] = solver
    file.write_text(json.dumps(table), encoding="utf-8")


def _tolerance(file: Path) -> tuple[float, list[float]]:
    """The largest rtol at which the probed members are accurate enough, and their errors [m]."""
    plan = read_sweep_spec(file)
    specs = []
    for number in np.unique(np.linspace(0, len(plan.members) - 1, PROBED).astype(int)).tolist():
        packages = {b: plan.package(k) for b, k in plan.members[number].packages.items()}
        specs.append(RunSpec(CASE, SWEEP, plan.mechanism_of(number), packages))

    def tips(method: Method, rtol: float) -> list[Any]:
        changes = {"solver": _solver(method, rtol)}
        return [_tip(solve(spec.changed(changes))[0]) for spec in specs]

    exact = tips(REFERENCE, REFERENCE.rtols[0])
    for rtol in DEFAULT.rtols:
        there = zip(tips(DEFAULT, rtol), exact, strict=True)
        errors = [float(np.linalg.norm(ours - path, axis=1).max()) for ours, path in there]
        if max(errors) < GOAL:
            return rtol, errors
    raise RuntimeError(f"no tolerance of {DEFAULT.label} has errors below {GOAL:g} m")


def _tip(result: RunResult) -> Any:
    found = {s.name: s.values for s in result.signals}
    return np.column_stack([found["tip_x"], found["tip_y"]])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int)
    for key, value in measure(parser.parse_args().jobs).items():
        print(f"{key:24} {value}")


if __name__ == "__main__":
    main()
