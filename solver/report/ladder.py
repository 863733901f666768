"""Chart of the models of a run with [fidelity] in the page: error against CPU time, as SVG."""

import math
from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

from ..math.front import front

WIDTH, HEIGHT = 640, 330
LEFT, RIGHT, TOP, BOTTOM = 62, 14, 14, 44
SYMBOLS = {"model": "fid-model", "chosen": "fid-chosen", "check": "fid-check"}


def chart(found: Mapping[str, Any], title: str) -> str:
    """Return the chart of a ladder (plain data of `fidelity.ladder.Ladder`); "" without points.

    Models with an error of zero or without end are left out.
    """
    points = [(r["cpu"], r["error"], r["name"], "model") for r in found["rungs"]]
    points += [
        (found[key]["cpu"], found[key]["error"], found[key]["name"], key)
        for key in ("chosen", "check")
    ]
    shown = [p for p in points if p[0] > 0.0 and 0.0 < p[1] < 1e6]
    if not shown:
        return ""
    x = _Axis([p[0] for p in shown], LEFT, WIDTH - RIGHT)
    sizes = [p[1] for p in shown] + [v for v in (found["asked"], found["estimate"]) if v > 0.0]
    y = _Axis(sizes, HEIGHT - BOTTOM, TOP)
    parts = [*_grid(x, y)]
    best = [shown[i] for i in front([p[:2] for p in shown])]
    line = " ".join(f"{x(p[0]):.1f},{y(p[1]):.1f}" for p in best)
    parts.append(f"<polyline class='fid-front' fill='none' points='{line}'/>")
    asked = y(found["asked"])
    parts.append(_level("fid-asked", LEFT, WIDTH - RIGHT, asked))
    parts.append(
        f"<text class='fid-asked' x='{WIDTH - RIGHT - 4}' y='{asked - 4:.1f}' "
        "text-anchor='end'>asked</text>"
    )
    for cpu, error, name, kind in shown:
        parts.append(_symbol(kind, x(cpu), y(error), f"{name}: {cpu:.3g} s, error {error:.1e}"))
    if found["estimate"] > 0.0 and found["chosen"]["cpu"] > 0.0:
        at, height = x(found["chosen"]["cpu"]), y(found["estimate"])
        parts.append(_level("fid-estimate", at - 9, at + 9, height))
    label = escape(f"Error against CPU time of the models of {title}", quote=True)
    return (
        f"<svg class='fid' viewBox='0 0 {WIDTH} {HEIGHT}' role='img' aria-label='{label}'>"
        + "".join(parts)
        + "</svg>"
    )


class _Axis:
    """A logarithmic axis between two places."""

    def __init__(self, values: Iterable[float], begin: float, end: float) -> None:
        logs = [math.log10(value) for value in values]
        self.low, self.high = math.floor(min(logs) * 2) / 2, math.ceil(max(logs) * 2) / 2
        if self.high == self.low:
            self.high += 0.5
        self.begin, self.end = begin, end

    def __call__(self, value: float) -> float:
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)

    def decades(self) -> list[int]:
        """Powers of ten within the axis."""
        return list(range(math.ceil(self.low), math.floor(self.high) + 1))


def _grid(x: _Axis, y: _Axis) -> list[str]:
    low, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    found = []
    for n in x.decades():
        at = f"{x(10.0**n):.1f}"
        found.append(f"<line class='fid-grid' x1='{at}' x2='{at}' y1='{TOP}' y2='{low}'/>")
        found.append(f"<text x='{at}' y='{low + 16}' text-anchor='middle'>{10.0**n:g}</text>")
    for n in y.decades():
        height = y(10.0**n)
        found.append(_level("fid-grid", LEFT, right, height))
        found.append(f"<text x='{LEFT - 6}' y='{height + 4:.1f}' text-anchor='end'>1e{n}</text>")
    middle = (LEFT + right) / 2
    found.append(
        f"<text x='{middle}' y='{HEIGHT - 8}' text-anchor='middle'>CPU time of a run [s]</text>"
    )
    found.append(
        f"<text transform='translate(14 {(TOP + low) / 2}) rotate(-90)' text-anchor='middle'>"
        "error / largest value</text>"
    )
    return found


def _level(kind: str, x1: float, x2: float, y: float) -> str:
    return f"<line class='{kind}' x1='{x1:.1f}' x2='{x2:.1f}' y1='{y:.1f}' y2='{y:.1f}'/>"


def _symbol(kind: str, x: float, y: float, words: str) -> str:
    shapes = {
        "model": f"<circle cx='{x:.1f}' cy='{y:.1f}' r='3.5'/>",
        "chosen": f"<path d='M{x:.1f} {y - 7:.1f} l7 7 l-7 7 l-7 -7 z'/>",
        "check": f"<rect x='{x - 5:.1f}' y='{y - 5:.1f}' width='10' height='10'/>",
    }
    return f"<g class='{SYMBOLS[kind]}'><title>{escape(words)}</title>{shapes[kind]}</g>"
