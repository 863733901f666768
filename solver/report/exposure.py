"""Exposure 1/R of the plies along each beam."""

from pathlib import Path
from typing import Any

from .story import Story
from .style import DASHES, WARNING, Canvas, colour

NEAR = 0.3  # exposure above which the line of failure is drawn


def draw_exposure(path: Path, story: Story) -> Path:
    """Draw, for each body of a run, the highest exposure 1/R over time against the station."""
    bodies: dict[str, Any] = story.summary["strength"]
    canvas = Canvas(5.4, 0.9 + 2.1 * len(bodies))
    # Far from failure, the line of failure would compress the curves onto the axis.
    for axes, (name, found) in zip(canvas.panels(len(bodies)), bodies.items(), strict=True):
        along = found["along_beam"]
        for i, (criterion, values) in enumerate(along["exposure"].items()):
            shade, dash = colour(i), DASHES[i % len(DASHES)]
            axes.plot(along["x"], values, color=shade, linestyle=dash, label=criterion)
        highest = max(max(values) for values in along["exposure"].values())
        if highest > NEAR:
            axes.axhline(1.0, color=WARNING, linewidth=1.0, linestyle=(0, (3, 2)), zorder=1)
        axes.set_ylim(0.0, 1.08 * max(highest, 1.0 if highest > NEAR else 1e-12))
        axes.margins(x=0.0)
        axes.set_title(f"{story.title}: {name}")
        axes.set_ylabel("exposure 1/R [-]\n(failure at 1)")
        axes.set_xlabel("x along the beam [m]")
        axes.legend(ncols=2, columnspacing=1.2, handlelength=2.0, loc="best")
    return canvas.save(path)
