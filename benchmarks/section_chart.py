"""Draw error against time from the numbers of section_convergence.py.

.venv/bin/python benchmarks/section_chart.py JSON PNG
"""

import json
import sys
from pathlib import Path
from typing import Any

from plymotion.solver.report.style import INK, Canvas, colour, house_style

MARKERS = {1: "^", 2: "o", 3: "s"}


def main(numbers: Path, picture: Path) -> None:
    found = json.loads(numbers.read_text(encoding="utf-8"))
    sections = list(dict.fromkeys(curve["section"] for curve in found["curves"]))
    with house_style():
        canvas = Canvas(10.0, 4.0)
        for axis, section in zip(
            canvas.panels(1, len(sections), sharex=True, sharey=True), sections, strict=True
        ):
            for curve in found["curves"]:
                if curve["section"] == section:
                    draw(axis, curve["degree"], curve["points"])
            axis.set(title=section, xlabel="time from mesh to K [ms]", xscale="log", yscale="log")
            axis.margins(x=0.12)
        canvas.figure.axes[0].set_ylabel("worst entry of K, error / sqrt(Kii Kjj)")
        canvas.figure.suptitle("Error against time, by degree of the field; ring: the default mesh")
        canvas.save(picture)


def draw(axis: Any, degree: int, points: list[dict[str, float]]) -> None:
    """One line, its degree written at its end."""
    seconds = [1e3 * point["seconds"] for point in points]
    errors = [point["error"] for point in points]
    line = colour(degree - 1)
    axis.plot(seconds, errors, marker=MARKERS[degree], markersize=4, color=line)
    axis.annotate(
        f"degree {degree}",
        (seconds[-1], errors[-1]),
        xytext=(-2, -13),
        textcoords="offset points",
        color=line,
        fontweight="bold",
        ha="right",
    )
    for point, x, y in zip(points, seconds, errors, strict=True):
        if point["density"] == 1 and degree == 2:
            axis.plot(x, y, "o", markersize=11, markerfacecolor="none", markeredgecolor=INK)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
