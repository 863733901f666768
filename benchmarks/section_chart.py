"""Draw error against time and unknowns from the numbers of section_convergence.py.

.venv/bin/python benchmarks/section_chart.py JSON PNG
"""

import json
import sys
from pathlib import Path
from typing import Any

from plymotion.solver.report.style import INK, Canvas, colour, house_style

MARKERS = {1: "^", 2: "o", 3: "s"}
LIFT = {1: 0, 2: 4, 3: -4}  # of the labels [pt]: two lines end close together
ROOM = 8.0  # for the labels right of the last points, as a factor
AXES = {"seconds": (1e3, "time from mesh to K [ms]"), "dofs": (1.0, "unknowns")}


def main(numbers: Path, picture: Path) -> None:
    found = json.loads(numbers.read_text(encoding="utf-8"))
    sections = list(dict.fromkeys(curve["section"] for curve in found["curves"]))
    with house_style(formulas=True):
        canvas = Canvas(10.0, 6.4)
        panels = canvas.panels(len(AXES), len(sections), sharex="row", sharey=True)
        for i, (key, (unit, label)) in enumerate(AXES.items()):
            row = panels[i * len(sections) : (i + 1) * len(sections)]
            for axis, section in zip(row, sections, strict=True):
                for curve in found["curves"]:
                    if curve["section"] == section:
                        draw(axis, curve["degree"], curve["points"], key, unit)
                axis.set(xlabel=label, xscale="log", yscale="log")
                if i == 0:
                    axis.set_title(section)
            last = max(point[key] for curve in found["curves"] for point in curve["points"])
            row[0].set_xlim(right=ROOM * unit * last)
            row[0].set_ylabel("worst error of K")
        panels[0].set_ylim(bottom=0.3 * lowest(found))
        canvas.figure.suptitle(
            "Largest error / sqrt(Kii Kjj) by degree of the field; ring: the default mesh "
            f"(DOLFINx {found['versions']['dolfinx']}, one core)"
        )
        canvas.save(picture, own=True)


def lowest(found: dict[str, Any]) -> float:
    """The smallest error of all curves."""
    return min(point["error"] for curve in found["curves"] for point in curve["points"])


def draw(axis: Any, degree: int, points: list[dict[str, float]], key: str, unit: float) -> None:
    """One line, its degree written at its end."""
    x = [unit * point[key] for point in points]
    errors = [point["error"] for point in points]
    line = colour(degree - 1)
    axis.plot(x, errors, marker=MARKERS[degree], markersize=4, color=line)
    axis.annotate(
        f"degree {degree}",
        (x[-1], errors[-1]),
        xytext=(7, LIFT[degree]),
        textcoords="offset points",
        color=line,
        fontweight="bold",
        va="center",
    )
    for point, a, b in zip(points, x, errors, strict=True):
        if point["density"] == 1 and degree == 2:
            axis.plot(a, b, "o", markersize=11, markerfacecolor="none", markeredgecolor=INK)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
