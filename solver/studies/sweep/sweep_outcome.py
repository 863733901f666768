"""The results of a sweep on the screen and as figures."""

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...report.style import GREY, INK, WARNING, Canvas, colour, house_style, unit_text
from ...results.codes import CODES
from .file import FAILED, FINISHED, PENDING, STOPPED, SweepResult

# What became of the members of a sweep, on the screen.

MOST = 10  # kinds of messages of members that did not finish
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


def outcome_lines(
    result: SweepResult, kept: int, seconds: float, planned: Sequence[str] = ()
) -> list[str]:
    """Return what became of the members, in words.

    Parameters
    ----------
    kept : how many were not computed; the others took `seconds`
    planned : lines on the plan of [fidelity]
    """
    total = len(result.rows)
    counts = [
        f"{result.count(s)} {s}" for s in (FINISHED, STOPPED, FAILED, PENDING) if result.count(s)
    ]
    computed = total - kept - result.count(PENDING)
    lines = [
        f"{result.name}: {total} members, {', '.join(counts)}",
        f"  {computed} computed in {seconds:.1f} s, {kept} kept from before",
        *(f"  {line}" for line in planned),
    ]
    # Members that did not finish, in groups whose messages differ in numbers only.
    alike: dict[tuple[str, str, str], list[int]] = {}
    for k, row in enumerate(result.rows):
        if row.status not in (FINISHED, PENDING):
            key = row.status, row.code, NUMBER.sub("#", row.message)
            alike.setdefault(key, []).append(k)
    groups = list(alike.values())
    for members in groups[:MOST]:
        row = result.rows[members[0]]
        values = zip(result.parameter_names, result.values[members[0]], strict=True)
        where = ", ".join(f"{name} = {value:g}" for name, value in values)
        code = f" [{row.code}]" if row.code else ""
        many = f"{len(members)} members, first " if len(members) > 1 else ""
        lines.append(f"  {row.status}{code} {many}{where}: {row.message}")
    if len(groups) > MOST:
        lines.append(f"  ... and {sum(map(len, groups[MOST:]))} more members")
    doubts = Counter(code for row in result.rows for code in row.warnings)
    for code, count in sorted(doubts.items()):
        level = CODES[code].level if code in CODES else "warning"
        lines.append(f"  {level} [{code}] in {count} of {total} members")
    return lines


# Figures of a sweep: each signal's final value and extremes against what was varied.

SHOWN = (("final", "final value"), ("min", "smallest"), ("max", "largest"))
FAMILY = 6  # values of one of two parameters up to which curves are drawn in place of a map


def draw_sweep(folder: Path, result: SweepResult, formats: Sequence[str]) -> list[Path]:
    """Draw DIR/<signal>.png, .svg, .pdf of every signal. Raises InputError without matplotlib.

    Parameters
    ----------
    folder : folder of the files
    result : results of the sweep
    formats : endings of the files, without a dot
    """
    if not formats:
        return []
    with house_style():
        return [
            draw_signal(folder / f"{name}.{form}", result, name)
            for name in result.signal_units
            if np.isfinite(result.signal(name, "min")).any()
            for form in formats
        ]


def draw_signal(path: Path, result: SweepResult, name: str) -> Path:
    """Draw one signal: curves over one parameter, a map over two, points over more.

    Parameters
    ----------
    path : file of the picture
    result : results of the sweep
    name : name of the signal
    """
    axes_values = [np.unique(column) for column in result.values.T]
    varied = [i for i, values in enumerate(axes_values) if len(values) > 1] or [0]
    full = len(result.rows) == np.prod([len(axes_values[i]) for i in varied])
    if len(varied) == 1:
        canvas = _curves(result, name, varied[0], None)
    elif len(varied) == 2 and full:
        few = min(varied, key=lambda i: len(axes_values[i]))
        if len(axes_values[few]) <= FAMILY:
            canvas = _curves(result, name, next(i for i in varied if i != few), few)
        else:
            canvas = _map(result, name, varied)
    else:
        canvas = _points(result, name, varied)
    label = result.signal_words[name] or name
    canvas.figure.suptitle(
        f"{result.title}: {label}{unit_text(result.signal_units[name])}",
        fontsize=10.5,
        fontweight="bold",
        x=0.02,
        ha="left",
    )
    lost = result.count(STOPPED, FAILED)
    if lost:
        note = f"x: {lost} of {len(result.rows)} members stopped or failed; values up to there"
        canvas.figure.supxlabel(note, fontsize=7.5, color=GREY, x=0.98, ha="right")
    return canvas.save(path)


def _curves(result: SweepResult, name: str, along: int, few: int | None) -> Canvas:
    """Draw a panel for each measure, a curve for each value of the parameter `few`."""
    canvas = Canvas(10.0, 3.4)
    panels = canvas.panels(1, len(SHOWN))
    panels[0].set_ylabel(_signal(result, name))
    x = result.values[:, along]
    family = [None] if few is None else list(np.unique(result.values[:, few]))
    early = _early(result)
    for axes, (measure, title) in zip(panels, SHOWN, strict=True):
        y = result.signal(name, measure)
        for i, value in enumerate(family):
            own = np.ones(len(x), dtype=bool) if few is None else result.values[:, few] == value
            order = np.flatnonzero(own)[np.argsort(x[own], kind="stable")]
            label = None if few is None else f"{value:g}"
            line = np.where(early, np.nan, y)[order]  # no line to what ended at another time
            axes.plot(x[order], line, "o-", markersize=3, color=colour(i), label=label)
            gone = order[early[order]]
            axes.plot(x[gone], y[gone], "x", color=colour(i), markersize=6)
        axes.set(title=title, xlabel=_label(result, along))
    if few is not None:
        handles = panels[0].get_legend_handles_labels()
        canvas.figure.legend(*handles, loc="outside right center", title=_label(result, few))
    return canvas


def _map(result: SweepResult, name: str, varied: list[int]) -> Canvas:
    """Draw a map for each measure over two parameters."""
    canvas = Canvas(11.0, 3.6)
    panels = canvas.panels(1, len(SHOWN))
    i, j = varied
    across, i_at = np.unique(result.values[:, i], return_inverse=True)
    up, j_at = np.unique(result.values[:, j], return_inverse=True)
    early = _early(result)
    for axes, (measure, label) in zip(panels, SHOWN, strict=True):
        field = np.full((len(up), len(across)), np.nan)
        field[j_at, i_at] = result.signal(name, measure)
        image = axes.pcolormesh(
            across, up, np.ma.masked_invalid(field), shading="nearest", cmap="cividis"
        )
        axes.plot(result.values[early, i], result.values[early, j], "x", color=WARNING)
        axes.grid(False)
        axes.set(title=label, xlabel=_label(result, i))
        canvas.figure.colorbar(image, ax=axes, label=_signal(result, name))
    panels[0].set_ylabel(_label(result, j))
    return canvas


def _points(result: SweepResult, name: str, varied: list[int]) -> Canvas:
    """Draw a point for each member, a row of panels for each measure."""
    canvas = Canvas(3.2 * len(varied) + 0.6, 2.4 * len(SHOWN) + 0.4)
    panels = canvas.panels(len(SHOWN), len(varied), sharex="col", sharey="row")
    early = _early(result)
    for row, (measure, label) in enumerate(SHOWN):
        y = result.signal(name, measure)
        for column, i in enumerate(varied):
            axes, x = panels[row * len(varied) + column], result.values[:, i]
            axes.plot(x[~early], y[~early], "o", markersize=3, color=colour(0))
            axes.plot(x[early], y[early], "x", color=WARNING)
            if column == 0:
                axes.set_ylabel(f"{label}\n{_signal(result, name)}", color=INK)
            if row == len(SHOWN) - 1:
                axes.set_xlabel(_label(result, i))
    return canvas


def _signal(result: SweepResult, name: str) -> str:
    """Return name and unit of a signal, for an axis."""
    return f"{name}{unit_text(result.signal_units[name])}"


def _early(result: SweepResult) -> NDArray[np.bool_]:
    """Return a mask (k,) of the members that ended early."""
    return np.array([row.status in (STOPPED, FAILED) for row in result.rows], dtype=bool)


def _label(result: SweepResult, parameter: int) -> str:
    name, unit = result.parameter_names[parameter], result.parameter_units[parameter]
    return f"{name}{unit_text(unit)}"
