"""Draw the solver's charts from the CSV files of solver_accuracy.py and solver_models.py.

.venv/bin/python benchmarks/solver_chart.py integrators|treatments|models CSV PNG
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.ticker import NullFormatter
from solver_csv import read
from solver_curves import front

from plymotion.solver.report.style import DASHES, GREY, INK, Canvas, colour, house_style

MARKERS = ("o", "s", "D", "^", "v", "P", "X", "<", ">", "p", "h")
PEER, FOREIGN = "Exudyn", ("scipy-", "ida")
PAIRED = "rk8, "  # with a treatment of constraints
Row = dict[str, str]


def _of(rows: Sequence[Row], **wanted: str) -> list[Row]:
    return [row for row in rows if all(row[k] == v for k, v in wanted.items())]


def _names(rows: Sequence[Row], key: str) -> list[str]:
    return list(dict.fromkeys(row[key] for row in rows))


def error_time(rows: list[Row], picture: Path, subject: str) -> None:
    """Error of the probe against processor time, a panel for each problem."""
    problems, labels = _names(rows, "problem"), _names(rows, "label")
    canvas = Canvas(12.0, 5.0)
    panels = canvas.panels(1, len(problems))
    for axis, problem in zip(panels, problems, strict=True):
        for k, label in enumerate(labels):
            done = [
                (float(r["error"]), float(r["cpu_s"]))
                for r in _of(rows, problem=problem, label=label, status="finished")
            ]
            if done:
                _curve(axis, done, label, k)
        axis.set(xscale="log", yscale="log", xlabel="processor time [s]")
        axis.set_title("\n".join(_names(_of(rows, problem=problem), "title")[0].split(", ", 1)))
    panels[0].set_ylabel("largest error of the tip [m]")
    handles: dict[str, Any] = {}
    for axis in panels:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    ordered = [label for label in labels if label in handles]
    columns = 7 if max(map(len, ordered)) < 20 else 5
    canvas.figure.legend(
        [handles[label] for label in ordered], ordered, loc="outside lower center", ncols=columns
    )
    canvas.figure.suptitle(f"Error against processor time, {subject}")
    canvas.save(picture, own=True)


def _curve(axis: Any, done: list[tuple[float, float]], label: str, k: int) -> None:
    """Every run as a point; the line joins those that no other run of the curve beats."""
    peer, foreign = label == PEER, label.startswith((*FOREIGN, PAIRED))
    shade = INK if peer else colour(k % 7)
    line = np.array(front(done))
    style = {"color": shade, "marker": MARKERS[k % len(MARKERS)], "markersize": 4.5}
    axis.plot(
        line[:, 1],
        line[:, 0],
        linestyle="--" if peer else (DASHES[2] if foreign else "-"),
        linewidth=1.8 if peer else 1.3,
        markerfacecolor="white" if foreign else shade,
        label=label,
        zorder=3 if peer else 2,
        **style,
    )
    beaten = np.array([p for p in done if p not in {tuple(q) for q in line}])
    if beaten.size:
        axis.plot(beaten[:, 1], beaten[:, 0], linestyle="", alpha=0.35, zorder=1, **style)


TITLES = {
    "double-pendulum": "double pendulum",
    "actuated-beam": "actuated beam",
    "chain-4": "chain of 4 links",
}


def models(rows: list[Row], picture: Path) -> None:
    """Mesh and mass form above, number of modes below."""
    studies = {study: _names(_of(rows, study=study), "problem") for study in ("mesh", "modes")}
    canvas = Canvas(11.0, 7.0)
    grid = canvas.figure.subfigures(2, 1)
    for figure, (study, problems) in zip(grid, studies.items(), strict=True):
        axes = figure.subplots(1, len(problems), squeeze=False).ravel()
        for axis, problem in zip(axes, problems, strict=True):
            part = _of(rows, study=study, problem=problem)
            for k, curve in enumerate(_names(part, "curve")):
                points = _of(part, curve=curve)
                _labelled(axis, points, curve, k, against_time=study == "modes")
            axis.set_yscale("log")
            axis.set_title(f"{study}: {TITLES[problem]}")
            if study == "mesh":
                axis.set_xscale("log", base=2)
                numbers = [int(n) for n in _names(part, "number")]
                axis.set_xticks(numbers, [str(n) for n in numbers])
                axis.set_xlabel("elements a body")
            else:
                axis.set_xscale("log")
                axis.set_xlabel("processor time [s]\n(numbers: bending modes)")
                _at_least_a_decade(axis)
            if len(_names(part, "curve")) > 1:
                axis.legend(loc="best")
        axes[0].set_ylabel("largest error of the tip [m]")
    canvas.figure.suptitle("Model error: distance from the finest model of each panel")
    canvas.save(picture, own=True)


def _at_least_a_decade(axis: Any) -> None:
    """Times that hardly differ look so, and the ticks have room for their labels."""
    low, high = axis.get_xlim()
    spare = np.sqrt(max(1.0, 10.0 * low / high))
    axis.set_xlim(low / spare, high * spare)
    axis.xaxis.set_minor_formatter(NullFormatter())


def _labelled(axis: Any, points: list[Row], curve: str, k: int, *, against_time: bool) -> None:
    key = "cpu_s" if against_time else "number"
    x = [float(p[key]) for p in points]
    y = [float(p["error"]) for p in points]
    axis.plot(x, y, color=colour(k), marker=MARKERS[k], markersize=5, label=curve)
    if against_time:
        for p, x_p, y_p in zip(points, x, y, strict=True):
            axis.annotate(
                p["number"], (x_p, y_p), (5, 4), textcoords="offset points", color=GREY, fontsize=8
            )


def main(kind: str, numbers: Path, picture: Path) -> None:
    rows = read(numbers)
    with house_style(formulas=True):
        if kind == "models":
            models(rows, picture)
        else:
            subject = "integrators" if kind == "integrators" else "treatments of the constraints"
            error_time(rows, picture, subject)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
