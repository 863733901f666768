"""Figures of a case: signals over time, spectra, motion, energy balance, exposure of plies."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..math.arrays import Array
from ..results import BodyGeometry, RunResult, Signal
from ..results.file import frames
from ..results.summary import spectrum
from .report_data import Comparison, Story
from .style import DASHES, GREY, INK, PALE, WARNING, Canvas, colour, mark_stop, unit_text

# Verification plot of a run: energies, error of the energy balance, constraint violation.

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
    for i, (name, legend) in enumerate(WORDS.items()):
        values = result.energies[name]
        values = values - values[0] if name == "potential" else values
        top.plot(result.t, values, color=colour(i), label=legend)
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
        legend = "zero" if result.violations else "not recorded by this run"
        bottom.text(0.5, 0.5, legend, transform=bottom.transAxes, ha="center", color=GREY)
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


# One signal of several runs over time, as in the paper's Figs. 10-15.

CROSSINGS = 8  # curves that cross more often than this get separate panels
SPREAD = 10.0  # curves whose ranges differ more than this get separate panels and scales


def draw_comparison(path: Path, wanted: Comparison, stories: list[Story]) -> Path:
    """Draw one picture: a common panel, or one panel per run if curves would overlap.

    Parameters
    ----------
    path : file of the picture
    wanted : signal, title and runs of the figure
    stories : runs of the case, with results and summary
    """
    given = [story.signal(wanted.signal) for story in stories]
    signals = [replace(s, values=np.where(np.isfinite(s.values), s.values, np.nan)) for s in given]
    t_full = max(float(story.result.t[-1]) for story in stories)
    uneven = not wanted.ratio and spread(signals) > SPREAD  # ratios have a logarithmic scale
    if crossings(stories, signals) > CROSSINGS or uneven:
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
    peaks = [float(np.nanmax(np.abs(s.values))) for s in signals if _known(s)] or [0.0]
    return max(peaks) / min(peaks) if min(peaks) > 0 else np.inf if max(peaks) > 0 else 1.0


def _known(signal: Signal) -> bool:
    return bool(np.isfinite(signal.values).any())


def _titled(wanted: Comparison, story: Story, signal: Signal) -> str:
    """Return the title of a run, which says so if its signal has no finite value."""
    if _known(signal):
        return story.title
    return f"{story.title}: {'no stress' if wanted.ratio else 'no finite values'}"


def _together(
    wanted: Comparison, stories: list[Story], signals: list[Signal], t_full: float
) -> Canvas:
    canvas = Canvas(7.6, 4.0)
    (axes,) = canvas.panels(1)
    for i, (story, signal) in enumerate(zip(stories, signals, strict=True)):
        t, values = story.result.t, signal.values
        style = {"color": colour(i), "linestyle": DASHES[i % len(DASHES)]}
        (line,) = axes.plot(t, values, label=_titled(wanted, story, signal), **style)
        if wanted.ratio and _known(signal):
            line.set_label(f"{story.title}, {_mark(axes, t, values, colour(i), smallest=True)}")
        if story.stopped:
            axes.plot(t[-1], values[-1], "x", color=colour(i), markersize=6)
            mark_stop(axes, float(t[-1]), t_full)
    axes.set_xlim(0, t_full)
    if wanted.ratio:
        axes.set_yscale("log")
    return _named(canvas, axes, wanted, "time [s]", _label(signals[0]))


def _named(canvas: Canvas, axes: Any, wanted: Comparison, along: str, up: str) -> Canvas:
    """Give one panel with a curve for each run its title, labels and legend."""
    axes.set(title=wanted.title, xlabel=along, ylabel=up)
    columns = min(3, len(axes.get_legend_handles_labels()[1]))
    canvas.figure.legend(loc="outside lower center", ncols=columns)
    return canvas


def _panels(
    wanted: Comparison, stories: list[Story], signals: list[Signal], t_full: float
) -> Canvas:
    every = list(zip(stories, signals, strict=True))
    missing = [_titled(wanted, *each) for each in every if not _known(each[1])]
    shown = [each for each in every if _known(each[1])]
    n = len(shown)
    shared = wanted.ratio or spread(signals) <= SPREAD
    canvas = Canvas(7.6, 1.0 + 1.55 * n)
    panels = canvas.panels(n, sharex=True, sharey=shared)
    for i, (axes, (story, signal)) in enumerate(zip(panels, shown, strict=True)):
        for other, pale in shown if shared else ():
            if other is not story:
                axes.plot(other.result.t, pale.values, color=PALE, linewidth=0.7, zorder=1)
        t, values = story.result.t, signal.values
        axes.plot(t, values, color=colour(i), zorder=3)
        words = _mark(axes, t, values, colour(i), smallest=wanted.ratio)
        axes.set_title(words, loc="right", fontsize=8, fontweight="normal", color=INK)
        if wanted.ratio:
            axes.set_yscale("log")
        axes.margins(y=0.08)
        if story.stopped:
            mark_stop(axes, float(t[-1]), t_full)
        axes.set_title(story.title, fontsize=9, color=colour(i))
    panels[-1].set_xlabel("time [s]")
    panels[-1].set_xlim(0, t_full)
    canvas.figure.supylabel(_label(signals[0]), fontsize=9, color=INK)
    canvas.figure.suptitle(wanted.title, fontsize=10.5, fontweight="bold", x=0.02, ha="left")
    circle = "smallest value" if wanted.ratio else "largest magnitude"
    note = "pale: the other runs, same scale" if shared else "each panel has its own scale"
    notes = "   |   ".join([f"circle: {circle}", note, *missing])
    canvas.figure.supxlabel(notes, fontsize=7.5, color=GREY, x=0.98, ha="right")
    return canvas


def _mark(axes: Any, t: Array, values: Array, shade: str, *, smallest: bool) -> str:
    """Mark the value that governs with a circle; return it and its time in words."""
    at = int(np.nanargmin(values) if smallest else np.nanargmax(np.abs(values)))
    axes.plot(t[at], values[at], "o", markersize=5, markerfacecolor="white", color=shade, zorder=4)
    number = values[at] if smallest else abs(values[at])
    return f"{'smallest' if smallest else 'largest'} {number:.3g} at {t[at]:.3f} s"


def _label(signal: Signal) -> str:
    return f"{signal.description or signal.name}{unit_text(signal.unit)}"


# Exposure 1/R of the plies along each beam.

NEAR = 0.3  # exposure above which the line of failure is drawn


def draw_exposure(path: Path, story: Story) -> Path:
    """Draw, for each body of a run, the highest exposure 1/R over time against the station."""
    bodies = story.summary["strength"]
    canvas = Canvas(5.4, 0.9 + 2.1 * len(bodies))
    # Far from failure, the line of failure would compress the curves onto the axis.
    for axes, (name, entry) in zip(canvas.panels(len(bodies)), bodies.items(), strict=True):
        along = entry["along_beam"]
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


# Figure of the motion: the bodies at some times, and the path of the tip.

INSTANTS = 15
MOST = 4000  # times that a path is drawn through
AXES = "xyz"


def draw_motion(path: Path, story: Story) -> Path:
    """Draw all bodies at evenly spaced times in the plane of their largest motion."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    result = story.result
    first, second = plane(result)
    rows = frames(len(result.t), MOST)
    points = result.node_positions_G[rows][:, :, [first, second]]
    canvas = Canvas(5.4, 5.2)
    (axes,) = canvas.panels(1)
    # Pale to dark in one hue: the order in time is also visible in black and white.
    fade = LinearSegmentedColormap.from_list("age", ["#B5D4EA", "#4A97C9", "#0A2F4A"])
    scale = Normalize(0.0, max(float(result.t[-1]), 1e-12))
    tip = outermost_point(points)
    axes.plot(points[:, tip, 0], points[:, tip, 1], color="#D55E00", linewidth=0.9, zorder=2)
    chosen = frames(len(rows), INSTANTS)
    for k in chosen:
        shade = fade(scale(result.t[rows[k]]))
        start = 0
        for body in result.bodies:
            own = points[k, start : start + len(body.nodes_B)]
            lines = LineCollection(
                segments(body, own), colors=[shade], linewidths=2.4, capstyle="round", zorder=3
            )
            axes.add_collection(lines)
            if len(own):
                axes.plot(*own[[0, -1]].T, "o", color=shade, markersize=4.2, zorder=4)
            start += len(body.nodes_B)
    _words(axes, story, points[:, tip])
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.autoscale_view()
    axes.set_xlabel(f"{AXES[first]} [m]")
    axes.set_ylabel(f"{AXES[second]} [m]")
    axes.set_title(story.title)
    bar = canvas.figure.colorbar(
        ScalarMappable(scale, fade), ax=axes, shrink=0.7, aspect=28, pad=0.02
    )
    bar.set_label("time [s]", color=INK)
    bar.outline.set_visible(False)
    canvas.figure.supxlabel(
        f"{len(chosen)} equidistant times; orange: path of the outermost point",
        fontsize=7.5,
        color=GREY,
    )
    return canvas.save(path)


def plane(result: RunResult) -> tuple[int, int]:
    """Return the two global axes along which the points spread most, in order x, y, z."""
    some = result.node_positions_G[frames(len(result.t), MOST)]
    spread = np.ptp(some.reshape(-1, 3), axis=0)
    drop = int(np.argmin(spread + np.array([2e-12, 1e-12, 0.0])))  # prefer x-y on a tie
    first, second = (axis for axis in range(3) if axis != drop)
    return first, second


def outermost_point(points: Array) -> int:
    """Return the index of the point that comes farthest from the one that moves least.

    points : (k, n, 2) positions of n points at k times
    """
    travelled = np.linalg.norm(np.diff(points, axis=0), axis=2).sum(axis=0)
    fixed = points[:, int(np.argmin(travelled))]
    away = np.linalg.norm(points - fixed[:, None], axis=2).max(axis=0)
    return int(np.flatnonzero(away >= away.max() * (1 - 1e-9))[-1])


def segments(body: BodyGeometry, own: Array) -> list[Array]:
    """Return the polylines of a body's cells, surfaces by their outline."""
    closed_rows = []
    for begin, end, kind in zip(body.offsets[:-1], body.offsets[1:], body.cell_types, strict=True):
        rows = body.connectivity[begin:end]
        closed = kind not in (1, 2, 3, 4, 21)  # points, lines, polylines, quadratic edges
        if kind == 21:
            rows = rows[[0, 2, 1]]
        closed_rows.append(own[np.append(rows, rows[0]) if closed else rows])
    return closed_rows


def _words(axes: Any, story: Story, path: Array) -> None:
    word, ink = ("stop", WARNING) if story.stopped else ("end", INK)
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
    style = {"textcoords": "offset points", "fontsize": 8, "bbox": box, "zorder": 6}
    axes.annotate("start", path[0], (6, 6), color=INK, **style)
    axes.annotate(f"{word}, {story.result.t[-1]:.4g} s", path[-1], (6, 6), color=ink, **style)


def draw_orbit(path: Path, wanted: Comparison, stories: list[Story]) -> Path:
    """Draw one signal against another, a curve for each run; one scale if they have one unit.

    Parameters
    ----------
    path : file of the picture
    wanted : signal, title and runs of the figure
    stories : runs of the case, with results and summary
    """
    canvas = Canvas(5.4, 5.0)
    (axes,) = canvas.panels(1)
    for i, story in enumerate(stories):
        along, up = story.signal(wanted.against), story.signal(wanted.signal)
        axes.plot(along.values, up.values, label=story.title, color=colour(i), linewidth=0.8)
        axes.plot(along.values[-1], up.values[-1], "o", color=colour(i), markersize=4)
    if along.unit == up.unit:
        axes.set_aspect("equal", adjustable="datalim")
    return _named(canvas, axes, wanted, _label(along), _label(up)).save(path)


# The amplitude spectrum of one signal of several runs.

SMALLEST = 1e-4  # of the largest amplitude: the lower end of the picture


def draw_spectrum(path: Path, wanted: Comparison, stories: list[Story]) -> Path:
    """Draw amplitudes over frequency, a curve for each run.

    Parameters
    ----------
    path : file of the picture
    wanted : signal, title and runs of the figure
    stories : runs of the case, with results and summary

    Raises
    ------
    InputError
        A signal with values that are not finite, or of too few output times.
    """
    canvas = Canvas(7.6, 4.0)
    (axes,) = canvas.panels(1)
    largest = 0.0
    for i, story in enumerate(stories):
        signal = story.signal(wanted.signal)
        try:
            frequency, amplitude = spectrum(story.result.t, signal.values)
        except ValueError as error:
            raise InputError(f"figures.{wanted.name}: run {story.name}: {error}") from error
        style = {"color": colour(i), "linestyle": DASHES[i % len(DASHES)]}
        axes.plot(frequency[1:], amplitude[1:], label=story.title, **style)
        largest = max(largest, float(np.max(amplitude[1:])))
    if largest > 0.0:
        axes.set_yscale("log")
        axes.set_ylim(SMALLEST * largest, 2.0 * largest)
    label = f"amplitude: {_label(signal)}"
    return _named(canvas, axes, wanted, "frequency [Hz]", label).save(path)
