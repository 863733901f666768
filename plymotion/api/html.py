"""Tables and small pictures in HTML for notebooks, without matplotlib."""

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np

from ..solver.math.arrays import Array

MOST_POINTS = 240  # of a curve: more are not seen
INK = "#0072B2"


class Markup(str):
    """Text that is HTML already."""


def text(value: object) -> str:
    """Return a value as HTML; numbers with six digits, None as a dash."""
    if isinstance(value, Markup):
        return value
    if isinstance(value, float | np.floating):
        return f"{value:.6g}"
    return "&ndash;" if value is None else escape(str(value))


def table(head: Sequence[str], rows: Iterable[Sequence[object]], caption: str = "") -> str:
    """Return a table; `head` names the columns."""
    top = "".join(f"<th>{escape(word)}</th>" for word in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{text(value)}</td>" for value in row) + "</tr>" for row in rows
    )
    title = f"<caption><b>{escape(caption)}</b></caption>" if caption else ""
    return f"<table>{title}<thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def curve(t: Array, values: Array, width: int = 260, height: int = 48) -> Markup:
    """Return a curve as an SVG picture without axes; values that are not finite leave gaps."""
    t, values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)
    known = np.isfinite(values)
    size = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    if not known.any() or len(t) < 2:
        return Markup(f"<svg {size}></svg>")
    rows = np.unique(np.linspace(0, len(t) - 1, MOST_POINTS).astype(int))
    # with the extremes, which a thinned curve would miss
    peaks = [int(np.nanargmin(np.where(known, values, np.nan)))]
    peaks += [int(np.nanargmax(np.where(known, values, np.nan)))]
    rows = np.unique([*rows, *peaks])
    low, high = values[known].min(), values[known].max()
    x = 2 + (width - 4) * (t[rows] - t[0]) / ((t[-1] - t[0]) or 1.0)
    y = height - 2 - (height - 4) * (values[rows] - low) / ((high - low) or 1.0)
    parts, pen = [], "M"
    for u, v in zip(x, y, strict=True):
        if np.isfinite(v):
            parts.append(f"{pen}{u:.1f} {v:.1f}")
            pen = "L"
        else:
            pen = "M"
    path = f'<path d="{"".join(parts)}" fill="none" stroke="{INK}" stroke-width="1.3"/>'
    return Markup(f"<svg {size}>{path}</svg>")
