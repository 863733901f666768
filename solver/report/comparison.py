"""One signal of several runs over time, as in the paper's Figs. 10-15."""

from pathlib import Path
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..results import Signal
from .story import Comparison, Story
from .style import DASHES, GREY, INK, PALE, Canvas, colour, mark_stop, unit_text

CROSSINGS = 8  # curves that cross more often than this get separate panels
SPREAD = 10.0  # curves whose ranges differ more than this get separate panels and scales


def draw_comparison(path: Path, wanted: Comparison, stories: list[Story]) -> Path:
    """Draw one picture: a common panel, or one panel per run if curves would overlap."""
    signals = [story.signal(wanted.signal) for story in stories]
    t_full = max(float(story.result.t[-1]) for story in stories)
    if crossings(stories, signals) > CROSSINGS or spread(signals) > SPREAD:
        canvas = _panels(wanted, stories, signals, t_full)
    else:
        canvas = _together(wanted, stories, signals, t_full)
    return canvas.save(path)


def crossings(stories: list[Story], signals: list[Signal]) -> int:
    """Largest number of crossings between two curves."""
    most = 0
    for i in range(len(signals)):
        for j in range(i):
            t = stories[i].result.t
            t = t[t <= stories[j].result.t[-1]]
            other = np.interp(t, stories[j].result.t, signals[j].values)
            gap = signals[i].values[: len(t)] - other
            gap = gap[np.abs(gap) > 1e-12]
            most = max(most, int(np.sum(gap[1:] * gap[:-1] < 0)))
    return most


def spread(signals: list[Signal]) -> float:
    """Return the ratio of the largest to the smallest magnitude among curves."""
    peaks = [float(np.nanmax(np.abs(signal.values))) for signal in signals]
    return max(peaks) / min(peaks) if min(peaks) > 0 else np.inf if max(peaks) > 0 else 1.0


def _together(
    wanted: Comparison, stories: list[Story], signals: list[Signal], t_full: float
) -> Canvas:
    canvas = Canvas(7.6, 4.0)
    (axes,) = canvas.panels(1)
    for i, (story, signal) in enumerate(zip(stories, signals, strict=True)):
        t, values = story.result.t, signal.values
        style = {"color": colour(i), "linestyle": DASHES[i % len(DASHES)]}
        axes.plot(t, values, label=story.title, **style)
        if story.stopped:
            axes.plot(t[-1], values[-1], "x", color=colour(i), markersize=6)
            mark_stop(axes, float(t[-1]), t_full)
    axes.set_title(wanted.title)
    axes.set_xlabel("time [s]")
    axes.set_ylabel(_label(signals[0]))
    axes.set_xlim(0, t_full)
    canvas.figure.legend(loc="outside lower center", ncols=min(3, len(stories)))
    return canvas


def _panels(
    wanted: Comparison, stories: list[Story], signals: list[Signal], t_full: float
) -> Canvas:
    n = len(stories)
    shared = spread(signals) <= SPREAD
    canvas = Canvas(7.6, 1.0 + 1.55 * n)
    panels = canvas.panels(n, sharex=True, sharey=shared)
    low = min(float(np.nanmin(s.values)) for s in signals)
    high = max(float(np.nanmax(s.values)) for s in signals)
    for i, axes in enumerate(panels):
        if shared:
            for j in range(n):
                if j != i:
                    axes.plot(
                        stories[j].result.t, signals[j].values, color=PALE, linewidth=0.7, zorder=1
                    )
            margin = 0.08 * (high - low)
            axes.set_ylim(low - margin, high + margin)
        t, values = stories[i].result.t, signals[i].values
        axes.plot(t, values, color=colour(i), zorder=3)
        _mark_peak(axes, t, values, colour(i))
        if stories[i].stopped:
            mark_stop(axes, float(t[-1]), t_full)
        axes.set_title(stories[i].title, fontsize=9, color=colour(i))
    panels[-1].set_xlabel("time [s]")
    panels[-1].set_xlim(0, t_full)
    canvas.figure.supylabel(_label(signals[0]), fontsize=9, color=INK)
    canvas.figure.suptitle(wanted.title, fontsize=10.5, fontweight="bold", x=0.02, ha="left")
    note = "pale: the other runs, same scale" if shared else "each panel has its own scale"
    canvas.figure.supxlabel(
        f"circle: largest magnitude   |   {note}", fontsize=7.5, color=GREY, x=0.98, ha="right"
    )
    return canvas


def _mark_peak(axes: Any, t: Array, values: Array, shade: str) -> None:
    at = int(np.nanargmax(np.abs(values)))
    axes.plot(t[at], values[at], "o", markersize=5, markerfacecolor="white", color=shade, zorder=4)
    axes.set_title(
        f"largest {abs(values[at]):.3g} at {t[at]:.3f} s",
        loc="right",
        fontsize=8,
        fontweight="normal",
        color=INK,
    )


def _label(signal: Signal) -> str:
    return f"{signal.description or signal.name}{unit_text(signal.unit)}"
