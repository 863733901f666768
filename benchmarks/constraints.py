"""Treatments of the constraints on mechanisms where they fail or differ: who passes, at what cost.

PYTHONPATH=.:tests .venv/bin/python benchmarks/constraints.py

Writes build/benchmarks/constraints.csv, docs/pictures/constraint-drift.png and
constraint-error-time.png, and prints the tables of docs/constraints.md. Takes about ten minutes.
"""

import csv
import time
import tomllib
from collections.abc import Callable
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.ticker import NullFormatter
from samples.constraint_runs import new_run, prepared, run
from samples.mechanism_samples import Sample, bricard, chain, four_bars, pendulum

from plymotion.solver.checks.singularity import SingularityMonitor
from plymotion.solver.dynamics.elements.constraints.treatment import IMPLICIT, Treatment
from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.integrators.generic.drive import Solution, integrate
from plymotion.solver.report.style import COLOURS, house_style
from plymotion.solver.studies.compiling import compile_ahead

REFERENCE = Path("tests/reference/dynamics")
CSV = Path("build/benchmarks/constraints.csv")
PICTURES = Path("docs/pictures")

TREATMENTS = {
    "index1": Treatment("index1"),
    "baumgarte 5/5": Treatment("baumgarte"),
    "baumgarte 50/50": Treatment("baumgarte", alpha=50.0, beta=50.0),
    "augmented-lagrangian": Treatment("augmented-lagrangian"),
    "projection": Treatment("projection"),
    "ggl": Treatment("ggl"),
    "index3": Treatment("index3"),
}
EXPLICIT_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
IMPLICIT_TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)


@dataclass(frozen=True)
class Problem:
    """A mechanism, how long it runs, and where its probe ends."""

    make: Callable[[], Sample]
    t_end: float
    exact: tuple[float, ...]  # of the probe at t_end; as many coordinates as are known
    allowed: float  # error that counts as passed [m]


@dataclass(frozen=True)
class Row:
    """One run."""

    problem: str
    treatment: str
    rtol: float
    status: str
    t: float
    error: float
    energy: float
    gap: float
    steps: int
    evaluations: int
    cpu_s: float


def _data(name: str) -> dict:
    return tomllib.loads((REFERENCE / f"{name}.toml").read_text(encoding="utf-8"))


def _problems() -> dict[str, Problem]:
    swing, bars, closed = _data("a01_pendulum"), _data("a02_n_four_bar"), _data("a04_bricard")
    last = swing["positions"][-1]
    found = {
        "pendulum (A01)": Problem(pendulum, 10.0, (last["x"], last["y"]), 1e-4),
        "4 redundant four-bars": Problem(lambda: four_bars(4), 0.6, (), 1e-4),
        "N-four-bar, N = 2 (A02)": Problem(
            lambda: four_bars(2), 10.0, tuple(bars["n-2"]["exact"]), bars["tolerance"]
        ),
        "Bricard (A04)": Problem(
            bricard, 10.0, tuple(closed["positions"][-1]["x"]), closed["tolerance"]
        ),
        "spherical chain of 4": Problem(lambda: chain(4, "spherical"), 1.0, (), 1e-4),
    }
    for name, problem in found.items():
        if not problem.exact:  # converged: no singular position on the way
            sample = problem.make()
            _, solution, _, _ = _run(problem, Treatment("projection"), 1e-12)
            exact = tuple(sample.place(solution.y[-1:])[0])
            found[name] = Problem(problem.make, problem.t_end, exact, problem.allowed)
    return found


def _run(
    problem: Problem, treatment: Treatment, rtol: float, n_out: int = 201
) -> tuple[Model, Solution, float, int]:
    """Model, solution, CPU time of integration, singular positions passed."""
    sample = problem.make()
    model, y0 = prepared(sample, treatment)
    options = {"rtol": rtol, "atol": 1e-2 * rtol}
    made = new_run(model, y0, treatment, "rk8", problem.t_end, **options)
    monitor = SingularityMonitor(model, sample.names, treatment.name)
    monitor.at_start(0.0, y0)
    begin = time.process_time()
    solution = integrate(made, np.linspace(0.0, problem.t_end, n_out), monitor)
    return model, solution, time.process_time() - begin, len(monitor.passes)


def _row(name: str, problem: Problem, label: str, rtol: float) -> tuple[Row, str]:
    model, solution, cpu, _ = _run(problem, TREATMENTS[label], rtol)
    balance, gap = [], 0.0
    for t, y in zip(solution.t, solution.y, strict=True):
        equations = assemble(model, t, y)
        balance.append(energies(model, equations, y).sum() - y[-1])
        gap = max(gap, float(np.abs(equations.Phi).max()))
    place = problem.make().place(solution.y[-1:])[0][: len(problem.exact)]
    error = float(np.linalg.norm(place - problem.exact))
    if solution.status != "finished":
        error = np.nan
    c = solution.counters
    status = solution.status if solution.status == "finished" else solution.code or solution.status
    row = Row(
        name,
        label,
        rtol,
        status,
        float(solution.t[-1]),
        error,
        float(np.ptp(balance)),
        gap,
        c.steps,
        c.evaluations,
        cpu,
    )
    return row, solution.message


def _measure() -> list[Row]:
    rows = []
    problems = _problems()
    for name, problem in problems.items():
        print(f"\n{name}, {problem.t_end:g} s\n")
        print("| treatment | rtol | end | error [m] | energy [J] | gap [m] | steps | CPU [s] |")
        print("|---|---|---|---|---|---|---|---|")
        for label, treatment in TREATMENTS.items():
            implicit = treatment.name in IMPLICIT
            words = ""
            for rtol in IMPLICIT_TOLERANCES if implicit else EXPLICIT_TOLERANCES:
                row, message = _row(name, problem, label, rtol)
                rows.append(row)
                end = "yes" if row.status == "finished" else f"{row.status}, {row.t:.3f} s"
                print(
                    f"| {label} | {rtol:.0e} | {end} | {row.error:.1e} | {row.energy:.1e} | "
                    f"{row.gap:.1e} | {row.steps} | {row.cpu_s:.2f} |",
                    flush=True,
                )
                words = message if row.status != "finished" else words
            if words:
                print(f"<!-- {label}: {words} -->")
    return rows


def _write(rows: list[Row]) -> None:
    CSV.parent.mkdir(parents=True, exist_ok=True)
    with CSV.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([f.name for f in fields(Row)])
        writer.writerows(astuple(row) for row in rows)


def _colours() -> dict[str, str]:
    return dict(zip(TREATMENTS, COLOURS, strict=True))


def _error_time(rows: list[Row], file: Path) -> None:
    problems = list(dict.fromkeys(row.problem for row in rows))
    with house_style(formulas=True):
        figure, grid = plt.subplots(2, 3, figsize=(11.0, 7.2))
        axes = grid.ravel()
        axes[-1].axis("off")
        for axis, problem in zip(axes, problems, strict=False):
            for label, colour in _colours().items():
                done = [
                    (row.cpu_s, row.error)
                    for row in rows
                    if (row.problem, row.treatment) == (problem, label) and row.error > 0
                ]
                if done:
                    axis.loglog(*np.array(done).T, "o-", color=colour, label=label, ms=4)
            axis.set_title(problem, fontsize=9)
            axis.set_xlabel("CPU time [s]")
            axis.set_ylabel("error of the probe at the end [m]")
            axis.xaxis.set_minor_formatter(NullFormatter())
        handles = {}
        for axis in axes:
            handles |= dict(zip(*axis.get_legend_handles_labels()[::-1], strict=True))
        axes[-1].legend(handles.values(), handles.keys(), loc="center", fontsize=9)
        figure.tight_layout()
        figure.savefig(file, dpi=120)
        plt.close(figure)


def _drift(file: Path) -> None:
    """|Phi| of the pendulum over time, rtol 1e-6."""
    problem = _problems()["pendulum (A01)"]
    with house_style(formulas=True):
        figure, axis = plt.subplots(figsize=(7.2, 4.2))
        for label, colour in _colours().items():
            treatment = TREATMENTS[label]
            rtol = 1e-4 if treatment.name in IMPLICIT else 1e-6
            done = run(problem.make(), treatment, [0.0, problem.t_end], rtol=rtol)
            gap = np.maximum(done.position, 1e-17)
            axis.semilogy(done.t, gap, color=colour, label=label, lw=1.2)
        axis.set_xlabel("t [s]")
        axis.set_ylabel("opening of the joint [m]")
        axis.set_title(
            "Pendulum A01, rtol 1e-6 (ggl, index3: 1e-4): ends of steps",
            fontsize=10,
        )
        axis.legend(fontsize=8, ncols=4, loc="upper center", bbox_to_anchor=(0.5, -0.14))
        figure.tight_layout()
        figure.savefig(file, dpi=120)
        plt.close(figure)


def main() -> None:
    compile_ahead()
    rows = _measure()
    _write(rows)
    PICTURES.mkdir(exist_ok=True)
    _error_time(rows, PICTURES / "constraint-error-time.png")
    _drift(PICTURES / "constraint-drift.png")
    print(f"\n{CSV}, {PICTURES}/constraint-*.png")


if __name__ == "__main__":
    main()
