"""`plymotion run` beside a whole process of Exudyn: import, load, build, solve, write."""

import json
import statistics
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import solver_exudyn
from exudyn_plane import MODIFIED
from processes import Cost, cost
from solver_methods import DEFAULT
from solver_problems import Problem, double_pendulum
from solver_runs import largest, reference, solve
from solver_time import rounds_until
from tqdm import tqdm

from plymotion.solver.math.arrays import Array

SPANS = (1.0, 10.0)  # [s] of motion
EVERY = 1e-3  # [s] between outputs, of both
LONG = 5.0  # [s]; longer processes scatter little and are not repeated
FIRST = 5000  # steps per second; from its error others follow, Exudyn is of second order
FINEST = 900_000  # steps; more take too long to try


def measure(rounds: int, targets: tuple[str, ...], end: float) -> list[dict[str, Any]]:
    """Rows by span and error: settings, errors, and medians of interleaved processes.

    None is repeated after `end` (solver_time.py).
    """
    rows = []
    for t_end in SPANS:
        problem = double_pendulum(t_end=t_end, name=f"double-pendulum-{t_end:g}")
        exact = reference(problem)
        theirs = _steps(problem, exact, targets)
        for target, ours in _tolerances(problem, exact, targets).items():
            rows.append({"t_end": t_end, "target": target, **ours, **theirs.get(target, {})})
    with tempfile.TemporaryDirectory() as folder:
        bodies = _write_bodies(Path(folder))
        runs = [_Pair(row, Path(folder), bodies) for row in rows]
        for pair in tqdm(runs, desc="warm", unit="pair"):
            pair.once()
        for _ in tqdm(rounds_until(rounds, end), total=rounds, desc="processes", unit="round"):
            for pair in runs:
                pair.once()
        return [pair.result() for pair in runs]


def _tolerances(
    problem: Problem, exact: Array, targets: tuple[str, ...]
) -> dict[str, dict[str, Any]]:
    """The largest rtol of the default integrator with an error below each target."""
    found: dict[str, dict[str, Any]] = {}
    for rtol in DEFAULT.rtols:
        result, summary, _ = solve(problem.with_solver(DEFAULT, rtol))
        error = largest(problem.places(result), exact)
        for target in targets:
            if error < float(target) and target not in found:
                steps = summary["cost"]["steps"]
                found[target] = {"rtol": rtol, "error": error, "steps": steps}
        if len(found) == len(targets):
            break
    return found


def _steps(problem: Problem, exact: Array, targets: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """The number of steps of Exudyn for each target, a hundred per second at a time."""
    unit = round(100 * problem.t_end)
    steps, found = round(FIRST * problem.t_end), {}
    error = _error(problem, exact, steps)
    for target in targets:
        goal = float(target)
        while error > goal or not 0.9 * goal < error:
            wanted = unit * int(np.ceil(steps * np.sqrt(error / (0.97 * goal)) / unit))
            if wanted > FINEST or abs(wanted - steps) <= unit:
                break
            steps, error = wanted, _error(problem, exact, wanted)
        if error <= goal:
            found[target] = {"exudyn_steps": steps, "exudyn_error": error}
    return found


def _error(problem: Problem, exact: Array, steps: int) -> float:
    tip, _ = solver_exudyn.double_pendulum(steps, MODIFIED, t_end=problem.t_end)
    return largest(tip, exact)


def _write_bodies(folder: Path) -> Path:
    """Arrays of the links for exudyn_process.py, which imports nothing of ours."""
    arrays = {
        f"{name}/{key}": value
        for name, body in zip(("arm", "hand"), solver_exudyn.links(), strict=True)
        for key, value in vars(body).items()
    }
    file = folder / "bodies.npz"
    np.savez(file, **arrays)
    return file


class _Pair:
    """Processes of both codes for one row; the first of each is not counted."""

    def __init__(self, row: dict[str, Any], folder: Path, bodies: Path) -> None:
        self.row, self.folder, self.bodies = row, folder, bodies
        t_end = row["t_end"]
        problem = double_pendulum(t_end=t_end, name=f"double-pendulum-{t_end:g}")
        solver = problem.solver(DEFAULT, row["rtol"]) | {"output_step": EVERY}
        self.file = problem.written(f"double-pendulum-{t_end:g}-{row['target']}", solver)
        self.ours: list[tuple[Cost, dict[str, float]]] = []
        self.theirs: list[tuple[Cost, dict[str, float]]] = []

    def once(self) -> None:
        """Run both, one after the other."""
        if not self.ours or self.ours[0][0].cpu_s < LONG:
            out = self.folder / "ours"
            used = cost(["-m", "plymotion", "run", str(self.file), "--out", str(out), "--quiet"])
            summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
            self.ours.append((used, summary["cost"]["seconds"]))
        if "exudyn_steps" in self.row and (not self.theirs or self.theirs[0][0].cpu_s < LONG):
            script = Path(__file__).with_name("exudyn_process.py")
            numbers = (self.row["t_end"], self.row["exudyn_steps"], MODIFIED, EVERY)
            arguments = [str(script), str(self.bodies), *map(str, numbers), str(self.folder)]
            used = cost(arguments)
            seconds = json.loads((self.folder / "seconds.json").read_text(encoding="utf-8"))
            self.theirs.append((used, seconds))

    def result(self) -> dict[str, Any]:
        """The row with medians; without Exudyn's where it did not reach the error."""
        row = {**self.row, "cpu_s": _median(self.ours), "seconds": _phases(self.ours)}
        if self.theirs:
            row |= {"exudyn_cpu_s": _median(self.theirs), "exudyn_seconds": _phases(self.theirs)}
        return row


def _counted(runs: list[Any]) -> list[Any]:
    return runs[1:] or runs


def _median(runs: list[tuple[Cost, dict[str, float]]]) -> float:
    return statistics.median(used.cpu_s for used, _ in _counted(runs))


def _phases(runs: list[tuple[Cost, dict[str, float]]]) -> dict[str, float]:
    names = runs[0][1]
    return {k: statistics.median(s[k] for _, s in _counted(runs)) for k in names}
