"""512 double pendulums (mass at the tip by speed) as a sweep, and one by one in plain NumPy.

.venv/bin/python benchmarks/ensemble.py [--t-end 0.02] [--members 512] [--singles 3]

Process CPU time, one process, from the sweep file to the rows of its table: packages read, models
built, motion integrated, every step watched, signals and checks evaluated; not the imports and not
the compilation of the step loop. Both take the same integrator and settings. A few single runs,
spread over the members, stand for all of them.

Plain NumPy runs the loops that are written to be compiled, and has become slower by that. So one
run of the case is also timed with the code of revision BEFORE, if the repository's history is
there: in plain NumPy as it was before anything was compiled whole, with its rk8.
"""

import argparse
import importlib
import io
import json
import os
import statistics
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).resolve().parent.parent
CASE = "double-pendulum"
T_END = 0.02  # [s] of motion
SETTINGS = {"integrator": "radau", "constraints": "projection"}
BEFORE = "057fef2"
OF_BEFORE = {"integrator": "rk8", "constraints": "baumgarte"}
ALLOWED = 1.0 / 20.0  # of the single runs


def measure(t_end: float = T_END, members: int = 512, singles: int = 3) -> dict[str, Any]:
    """Return times [s] of the sweep and of single runs, and their ratio.

    Parameters
    ----------
    members : of the sweep's 512, evenly chosen
    singles : runs that stand for all
    """
    with tempfile.TemporaryDirectory() as folder:
        file = _checked(Path(folder), t_end)
        ensemble = _child(["--time", str(file), "--members", str(members)], compiled=True)
        single = _child(["--time", str(file), "--members", str(singles)], compiled=False)
    count = len(ensemble["seconds"])
    one = statistics.median(single["seconds"])
    total = ensemble["total"]
    found = {
        "case": f"{CASE}, sweep masses, isotropic, {t_end:g} s, {SETTINGS['integrator']}",
        "members": count,
        "t_end": t_end,
        "ensemble_s": total,
        "single_numpy_s": one,
        "single_numpy_runs_s": single["seconds"],
        "ratio": total / (count * one),
        "ratio_allowed": ALLOWED,
        "us_per_evaluation": 1e6 * total / sum(ensemble["evaluations"]),
        "compiled": ensemble["compiled"],
    }
    if (before := _before(t_end)) is not None:
        found |= {
            "revision_before": BEFORE,
            "single_numpy_before_s": before,
            "ratio_before": total / (count * before),
        }
    return found


def _before(t_end: float) -> float | None:
    """Time [s] of a single run by revision BEFORE; None without its files."""
    git = ["git", "-C", str(REPOSITORY), "archive", BEFORE]
    try:
        archive = subprocess.run(git, capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            files.extractall(folder, filter="data")
        found = _child(["--time-run", folder, "--t-end", str(t_end)], compiled=False, home=folder)
    return float(found["seconds"])


def _time_run(repository: Path, t_end: float) -> dict[str, Any]:
    """Time the case's run `isotropic` in this process, by whatever code is imported."""
    old = (repository / "solver" / "run.py").is_file()  # before the rooms of today
    cases = "plymotion.solver.case" if old else "plymotion.solver.inputs.case"
    load_case = importlib.import_module(cases).load_case
    write_case = importlib.import_module(f"{cases}.specs").write_case
    module = "plymotion.solver.run" if old else "plymotion.solver.run.execution"
    runs = importlib.import_module(module)

    case = load_case(repository / "cases" / CASE / "case.toml")
    with tempfile.TemporaryDirectory() as folder:
        write_case(case, Path(folder), repository / "tests" / "packages" / CASE)
        file = Path(folder) / "runs" / "isotropic.json"
        table = json.loads(file.read_text(encoding="utf-8"))
        table["mechanism"]["solver"] |= {"t_end": t_end, **OF_BEFORE}
        file.write_text(json.dumps(table), encoding="utf-8")
        begin = time.process_time()
        _, summary = runs.execute(runs.read_run(file), progress=False)
        seconds = time.process_time() - begin
    if summary["status"] != "finished":
        raise RuntimeError(f"revision {BEFORE}: {summary}")
    return {"seconds": seconds}


def _checked(folder: Path, t_end: float) -> Path:
    """Check the case into a folder, with the packages of the repository; its sweep file."""
    from plymotion.solver.inputs.case import load_case
    from plymotion.solver.inputs.case.specs import write_case

    case = load_case(REPOSITORY / "cases" / CASE / "case.toml")
    write_case(case, folder, REPOSITORY / "tests" / "packages" / CASE)
    file = folder / "sweeps" / "masses.json"
    table = json.loads(file.read_text(encoding="utf-8"))
    table["mechanism"]["solver"] |= {"t_end": t_end, **SETTINGS}
    file.write_text(json.dumps(table), encoding="utf-8")
    return file


def _child(
    arguments: list[str], *, compiled: bool, home: str | Path = REPOSITORY
) -> dict[str, Any]:
    """Run this file in a fresh interpreter on the code in `home`; what it prints."""
    command = [sys.executable, str(Path(__file__).resolve()), *arguments]
    environment = {
        **os.environ,
        "PLYMOTION_COMPILED": "1" if compiled else "0",
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONPATH": str(home),
    }
    done = subprocess.run(
        command, env=environment, cwd=home, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def _time(file: Path, count: int) -> dict[str, Any]:
    """Compute `count` members in this process; CPU times [s]."""
    import numpy as np

    from plymotion.solver.commands.sweep.engine import compute_here
    from plymotion.solver.commands.sweep.member import Packages, Row, compute
    from plymotion.solver.commands.sweep.plan import read_plan
    from plymotion.solver.math.compiled import COMPILED

    plan = read_plan(file)
    numbers = np.unique(np.linspace(0, len(plan.members) - 1, count).astype(int)).tolist()
    keys = [str(k) for k in range(len(plan.members))]
    if COMPILED:  # what is compiled on first use
        compute(plan, Packages(plan), numbers[:1], keys[:1])
    rows: list[Row] = []
    seconds = []
    begin = time.process_time()
    if COMPILED:
        last = [begin]

        def report(number: int, row: Row) -> None:
            rows.append(row)
            seconds.append(time.process_time() - last[0])
            last[0] = time.process_time()

        compute_here(plan, numbers, keys, report)
    else:
        for number in numbers:
            start = time.process_time()
            rows += compute(plan, Packages(plan), [number], [keys[number]])
            seconds.append(time.process_time() - start)
    total = time.process_time() - begin
    unfinished = [row.message for row in rows if row.status != "finished"]
    if unfinished:
        raise RuntimeError(f"{len(unfinished)} members did not finish: {unfinished[0]}")
    return {
        "total": total,
        "seconds": seconds,
        "evaluations": [row.cost["evaluations"] for row in rows],
        "compiled": COMPILED,
    }


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--t-end", type=float, default=T_END)
    parser.add_argument("--members", type=int, default=512)
    parser.add_argument("--singles", type=int, default=3)
    parser.add_argument("--time", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--time-run", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.time:
        print(json.dumps(_time(options.time, options.members)))
        return
    if options.time_run:
        print(json.dumps(_time_run(options.time_run, options.t_end)))
        return
    found = measure(options.t_end, options.members, options.singles)
    print(f"{found['case']}, CPU time in one process")
    print(f"{found['members']} members as a sweep      {found['ensemble_s']:10.2f} s")
    print(f"one single run in NumPy     {found['single_numpy_s']:10.2f} s")
    print(f"sweep / {found['members']} single runs     {found['ratio']:10.4f}")
    if "ratio_before" in found:
        print(f"sweep / 512 runs of {BEFORE}    {found['ratio_before']:10.4f}")
    print(f"allowed                     {ALLOWED:10.4f}")


if __name__ == "__main__":
    main()
