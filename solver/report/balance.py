"""Verification plot of a run: energies, error of the energy balance, constraint violation."""

from pathlib import Path
from typing import Any

import numpy as np

from ..math.arrays import Array
from .story import Story
from .style import GREY, Canvas, colour, mark_stop

WORDS = {
    "kinetic": "kinetic",
    "strain": "strain",
    "potential": "potential (from start)",
    "drive_work": "work of drives",
}
UNITS = {"position": "m", "rotation": "rad", "velocity": "m/s, rad/s"}


def draw_balance(path: Path, story: Story) -> Path:
    """Draw energies, relative error of their balance and constraint violations over time."""
    result = story.result
    canvas = Canvas(5.4, 5.2)
    top, middle, bottom = canvas.panels(3, sharex=True, height_ratios=[1.5, 1, 1])
    for i, (name, words) in enumerate(WORDS.items()):
        values = result.energies[name]
        values = values - values[0] if name == "potential" else values
        top.plot(result.t, values, color=colour(i), label=words)
    title = story.title
    if story.stopped:
        title += f" (stopped at {result.t[-1]:.4g} s)"
    canvas.figure.suptitle(title, fontsize=10, fontweight="bold", x=0.02, ha="left")
    top.set_ylabel("energy [J]")
    above = {"loc": "lower left", "bbox_to_anchor": (-0.02, 0.98), "borderaxespad": 0.0}
    top.legend(ncols=4, columnspacing=1.2, handlelength=1.4, **above)

    _log(middle, result.t, np.abs(result.relative_balance), colour(0), "energy balance")
    middle.set_ylabel("error of the\nenergy balance [-]")
    shown = [n for n, values in result.violations.items() if np.any(values > 0)]
    for i, name in enumerate(shown):
        label = f"{name} [{UNITS.get(name, '-')}]"
        _log(bottom, result.t, result.violations[name], colour(i), label)
    bottom.set_ylabel("constraint\nviolation")
    bottom.set_xlabel("time [s]")
    if shown:
        bottom.legend(ncols=3, columnspacing=1.2, handlelength=1.4, **above)
    else:
        words = "zero" if result.violations else "not recorded by this run"
        bottom.text(0.5, 0.5, words, transform=bottom.transAxes, ha="center", color=GREY)
        bottom.set_yticks([])
    top.set_xlim(0, max(float(result.t[-1]), 1e-12))
    for axes in (top, middle, bottom):
        if story.stopped:
            mark_stop(axes, float(result.t[-1]), float(result.t[-1]), label=False)
    return canvas.save(path)


def _log(axes: Any, t: Array, values: Array, shade: str, label: str) -> None:
    """Plot on a logarithmic scale; exact zeros are left out."""
    from matplotlib.ticker import LogFormatter

    axes.plot(t, np.where(values > 0, values, np.nan), color=shade, linewidth=1.0, label=label)
    if np.any(values > 0):
        axes.set_yscale("log")
        # 1e-12: powers as formulas take as long as all the rest of the layout.
        axes.yaxis.set_major_formatter(LogFormatter())
        axes.yaxis.set_minor_formatter(LogFormatter())
