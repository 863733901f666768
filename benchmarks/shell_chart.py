"""Draw the shells' charts from the numbers of shell_course.py and shell_error_time.py.

.venv/bin/python benchmarks/shell_chart.py course|error-time JSON PNG
"""

import json
import sys
from pathlib import Path
from typing import Any

from plymotion.solver.report.style import INK, PALE, Canvas, colour, house_style

MARKERS = ("o", "s", "D", "^", "v", "P", "X", "*", "p")
LAYUPS = {"0": "[0]6", "cas15": "CAS 15 (lay-up 3)"}


def course(found: dict[str, Any], picture: Path) -> None:
    """Displacement over reference against cells along an edge, one panel for each problem."""
    problems = list(dict.fromkeys(curve["problem"] for curve in found["curves"]))
    elements = list(dict.fromkeys(curve["elements"] for curve in found["curves"]))
    canvas = Canvas(11.0, 6.4)
    panels = canvas.panels(2, (len(problems) + 1) // 2, sharey=True)
    for axis, problem in zip(panels, problems, strict=False):
        axis.axhspan(0.98, 1.02, color=PALE, alpha=0.6, linewidth=0)
        for curve in found["curves"]:
            if curve["problem"] != problem:
                continue
            row = elements.index(curve["elements"])
            strong = row == 0
            axis.plot(
                curve["cells"],
                curve["ratios"],
                marker=MARKERS[row],
                markersize=5.5 if strong else 4,
                color=INK if strong else colour(row - 1),
                linewidth=2.0 if strong else 1.1,
                zorder=3 if strong else 2,
                label=curve["elements"],
            )
        axis.set_xscale("log", base=2)
        axis.set_xticks(curve_cells(found, problem), [f"{n}" for n in curve_cells(found, problem)])
        axis.set_title(problem)
    panels[0].set_ylim(0.0, 1.35)
    for axis in panels[:: (len(problems) + 1) // 2]:
        axis.set_ylabel("displacement / reference")
    for axis in panels[(len(problems) + 1) // 2 :]:
        axis.set_xlabel("cells along an edge, or across the strip")
    handles, labels = panels[0].get_legend_handles_labels()
    canvas.figure.legend(handles, labels, loc="outside lower center", ncols=4)
    canvas.figure.suptitle("Isotropic obstacle course (band: 2 % about the reference)")
    canvas.save(picture, own=True)


def curve_cells(found: dict[str, Any], problem: str) -> list[int]:
    """Meshes of a problem."""
    return next(list(curve["cells"]) for curve in found["curves"] if curve["problem"] == problem)


def against_time(found: dict[str, Any], picture: Path) -> None:
    """Worst error of f1..f6 of the box against time, one panel for each lay-up."""
    layups = list(dict.fromkeys(curve["layup"] for curve in found["curves"]))
    names = list(dict.fromkeys(curve["name"] for curve in found["curves"]))
    canvas = Canvas(10.0, 4.6)
    panels = canvas.panels(1, len(layups), sharey=True, sharex=True)
    for axis, layup in zip(panels, layups, strict=True):
        for curve in found["curves"]:
            if curve["layup"] != layup:
                continue
            row = names.index(curve["name"])
            peer = curve["name"].startswith("CalculiX")
            axis.plot(
                [point["seconds"] for point in curve["points"]],
                [100.0 * point["error"] for point in curve["points"]],
                marker=MARKERS[row],
                markersize=5,
                linestyle="--" if peer else "-",
                color=INK if row == 0 else colour(row - 1),
                label=curve["name"],
            )
        axis.set(xscale="log", yscale="log", xlabel="processor time [s]", title=LAYUPS[layup])
        for line in (axis.xaxis, axis.yaxis):  # the house style has no mathematical text
            line.set_major_formatter("{x:g}")
    panels[0].set_ylabel("largest error of f1..f6 [%]")
    handles, labels = panels[0].get_legend_handles_labels()
    canvas.figure.legend(handles, labels, loc="outside lower center", ncols=4)
    canvas.figure.suptitle(
        f"Box beam of the paper (DOLFINx {found['versions']['dolfinx']}, one core)"
    )
    canvas.save(picture, own=True)


def main(kind: str, numbers: Path, picture: Path) -> None:
    found = json.loads(numbers.read_text(encoding="utf-8"))
    with house_style(formulas=True):
        {"course": course, "error-time": against_time}[kind](found, picture)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
