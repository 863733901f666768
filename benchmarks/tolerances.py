"""Accuracy asked for and obtained: `rtol` of a run against the error of its positions.

.venv/bin/python benchmarks/tolerances.py CSV PNG

Runs of the shipped cases with their packages (no FEniCSx), through the function that
`plymotion run` calls. The error of a run is the largest difference of a position, deflection or
angle from rk8 with rtol = 1e-9 and absolute tolerances of 1e-11 and 1e-9, at 201 times, over the
size of the mechanism (angles: rad). The error of the reference itself is below a hundredth of what
is measured.
"""

import csv
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from plymotion.solver.dynamics.analysis.recovery import scales
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.math.arrays import Array
from plymotion.solver.report.style import Canvas, colour, house_style
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.run.preparation import prepare

# Case, run, end [s].
RUNS = (
    ("double-pendulum", "isotropic", 1.0),
    ("double-pendulum", "layup-1", 1.0),
    ("double-pendulum-limits", "isotropic-soft-following", 0.3),
    ("double-pendulum-limits", "isotropic-soft-free-stiffened", 0.3),
    ("double-pendulum-shell", "shell", 0.3),
    ("actuated-beam", "layup-1", 1.0),
    ("actuated-beam", "layup-3-root", 1.0),
    ("slider-crank", "steel", 0.12),
    ("slider-crank", "carbon-30", 0.12),
    ("n-four-bar", "n-2", 3.0),
    ("bricard", "hinges", 5.0),
    ("rotating-blade", "stiffened", 0.3),
    ("spin-up", "stiffened", 5.0),
    ("spin-up", "stiffened-chord", 5.0),
)
ASKED = (1e-3, 1e-4, 1e-5, 1e-6)
OUTPUTS = 200
REFERENCE = {
    "integrator": "rk8",
    "rtol": 1e-9,
    "atol_position": 1e-11,
    "atol_velocity": 1e-9,
}
BAND = 10.0  # of what is asked, that an error is not to exceed


def main() -> None:
    """Measure, write the table and draw it."""
    table, picture = map(Path, sys.argv[1:])
    rows = [row for case, run, t_end in RUNS for row in measured(case, run, t_end)]
    with table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    share = np.array([row["obtained"] / row["asked"] for row in rows])
    print(
        f"obtained / asked: median {np.median(share):.2g}, largest {share.max():.2g}, "
        f"least {share.min():.2g}, {share.size} runs"
    )
    draw(rows, picture)


def measured(case: str, run: str, t_end: float) -> list[dict[str, Any]]:
    """Rows of one run: case, run, asked, obtained, steps."""
    shipped = Path("tests/packages") / case
    with TemporaryDirectory() as folder:
        packages = shipped if shipped.exists() else None
        write_case(load_case(Path("cases") / case / "case.toml"), Path(folder), packages)
        spec = read_run(Path(folder) / "runs" / f"{run}.json")
    spec = spec.changed(
        {
            "solver.t_end": t_end,
            "solver.output_step": t_end / OUTPUTS,
            "solver.constraints": "projection",
        }
    )
    ready = prepare(spec.mechanism, spec.packages)
    size = scales(ready.model, ready.y0, t_end).length
    exact, _ = _motion(spec, REFERENCE, size)
    rows = []
    for asked in ASKED:
        motion, steps = _motion(spec, {"integrator": "radau", "rtol": asked}, size)
        obtained = float(np.abs(motion - exact).max())
        rows.append(
            {"case": case, "run": run, "asked": asked, "obtained": obtained, "steps": steps}
        )
        print(f"{case} {run}: asked {asked:g}, obtained {obtained:.2g}, {steps} steps", flush=True)
    return rows


def _motion(spec: RunSpec, settings: dict[str, Any], size: float) -> tuple[Array, int]:
    """Positions over the size, shares and angles at the output times (signals, k); steps."""
    changed = spec.changed({f"solver.{key}": value for key, value in settings.items()})
    result, summary = execute(changed, progress=False)
    if not summary["completed"]:
        raise SystemExit(f"{spec.case}, {spec.run}, {settings}: {summary['message']}")
    scale = {"m": size, "-": 1.0, "rad": 1.0}
    values = [s.values / scale[s.unit] for s in result.signals if s.unit in scale]
    return np.array(values), summary["cost"]["steps"]


def draw(rows: list[dict[str, Any]], picture: Path) -> None:
    """Error obtained over error asked for, a curve for each run."""
    with house_style(formulas=True):
        canvas = Canvas(9.5, 5.0)
        (axis,) = canvas.panels(1, 1)
        for k, (case, run, _) in enumerate(RUNS):
            mine = [row for row in rows if (row["case"], row["run"]) == (case, run)]
            axis.plot(
                [row["asked"] for row in mine],
                [row["obtained"] for row in mine],
                marker="os^"[k // 7 % 3],
                color=colour(k),
                label=f"{case}, {run}",
            )
        asked = np.array([ASKED[-1], ASKED[0]])
        axis.plot(asked, asked, color="black", linewidth=1.0)
        axis.fill_between(asked, asked / BAND, asked * BAND, color="black", alpha=0.08, linewidth=0)
        axis.set(xscale="log", yscale="log", xlabel="accuracy asked for: rtol")
        axis.set_ylabel("largest error of a position / size")
        axis.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5))
        canvas.figure.suptitle("Accuracy asked for and obtained, radau with default tolerances")
        canvas.save(picture, own=True)


if __name__ == "__main__":
    main()
