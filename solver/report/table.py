"""Tables, matrices, labelled lines and JSON as text for the screen; the table of a case's runs."""

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..package.common.plain_data import plain
from ..results.summary import Summary, findings, verdict

ROUND_OFF = 1e-10  # of sqrt(K_ii K_jj): smaller entries of a matrix are shown as 0
WIDTH = 100  # columns of the screen that tables of signals take
VALUES = {"final": 5, "min": 4, "max": 4}  # of a signal, and their digits
Signal = tuple[str, list[list[str]]]  # title, and values of each run


def summary_table(summaries: Sequence[Summary]) -> str:
    """Return aligned tables: outcome of the runs, and values of their signals."""
    if not summaries:
        return "no runs"
    head = ["run", "completed", "t_end", "violation", "energy drift", "steps", "solve", "warnings"]
    of_head = ["", "", "[s]", "[m]", "[-]", "", "[s]", ""]
    outcomes = [head, of_head, *([s["run"], *_outcome(s)] for s in summaries)]
    units = {n: t.get("unit", "") for s in summaries for n, t in s.get("signals", {}).items()}
    signals = [
        (f"{name} [{unit}]", [_values(s.get("signals", {}).get(name, {})) for s in summaries])
        for name, unit in units.items()
    ]
    names = [summary["run"] for summary in summaries]
    tables = [aligned(outcomes, left=(0, 7)), *_side_by_side(names, signals)]
    return "\n\n".join(tables)


def _values(signal: Mapping[str, Any]) -> list[str]:
    """Return final, smallest and largest value as text, and the error bar behind the first one."""
    final, *ends = [number(measure(signal, key), digits) for key, digits in VALUES.items()]
    bar = signal.get("error_bar")
    return [final if bar is None else f"{final} +- {number(bar, 1)}", *ends]


ROUNDING = 1e-12  # of the largest value of a signal


def measure(signal: Mapping[str, Any], key: str) -> float | None:
    """Return a value of a signal's summary; one that is rounding beside its extremes is 0."""
    value: float | None = signal.get(key)
    largest = max(abs(signal.get(end) or 0.0) for end in ("min", "max"))
    return 0.0 if value is not None and abs(value) < ROUNDING * largest else value


def _side_by_side(names: Sequence[str], signals: Sequence[Signal]) -> list[str]:
    """Return tables of signals: as many beside each other as there is room for."""
    tables: list[str] = []
    shown = 0
    while shown < len(signals):
        end = shown + 1
        table = _signal_table(names, signals[shown:end])
        while end < len(signals):
            wider = _signal_table(names, signals[shown : end + 1])
            if len(wider.splitlines()[2]) > WIDTH:
                break
            table, end = wider, end + 1
        tables.append(table)
        shown = end
    return tables


def _signal_table(names: Sequence[str], signals: Sequence[Signal]) -> str:
    top, below = ["run"], [""]
    rows = [[name] for name in names]
    for title, values in signals:
        top += [title, "", ""]
        below += VALUES
        for row, cells in zip(rows, values, strict=True):
            row += cells
    return aligned([top, below, *rows], left=(0,))


def number(value: float | None, digits: int = 3) -> str:
    """Write a number with some significant digits; a dash for none."""
    return "-" if value is None else f"{value:.{digits}g}"


def warning_codes(summary: Summary) -> list[str]:
    """Return the codes of the warnings, each once, with its count."""
    codes = [finding.code for finding in findings(summary)]
    return [f"{c} x{codes.count(c)}" if codes.count(c) > 1 else c for c in dict.fromkeys(codes)]


def _outcome(summary: Summary) -> list[str]:
    checks, cost = summary.get("checks", {}), summary.get("cost", {})
    return [
        ("invalid" if verdict(summary) == "bad" else "yes") if summary.get("completed") else "NO",
        number(summary.get("t_end"), 4),
        number(checks.get("constraint_position_max"), 2),
        number(checks.get("energy_drift_relative"), 2),
        str(cost.get("steps", "-")),
        number(cost.get("solve_s")),
        ", ".join(warning_codes(summary)) or "-",
    ]


def aligned(
    rows: Sequence[Sequence[str]], left: Collection[int] = (0,), *, head: int = 2, rule: bool = True
) -> str:
    """Return rows of cells as lines of equal columns.

    A cell of the first row extends over the empty cells after it.

    Parameters
    ----------
    left : columns aligned to the left
    head : rows that are headings
    rule : draw a line below them
    """
    widths = [max((len(row[i]) for row in rows[1:]), default=0) for i in range(len(rows[0]))]
    heads = [0, *(i for i, text in enumerate(rows[0]) if text and i)]
    top = []
    for first, end in zip(heads, [*heads[1:], len(widths)], strict=True):
        text, room = rows[0][first], sum(widths[first:end]) + 2 * (end - first - 1)
        widths[first] += max(0, len(text) - room)
        room = max(room, len(text))
        top.append(text.ljust(room) if first in left else text.rjust(room))
    lines = ["  ".join(top).rstrip()]
    for row in rows[1:]:
        cells = [
            text.ljust(width) if i in left else text.rjust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    if rule:
        lines.insert(head, "-" * (sum(widths) + 2 * (len(widths) - 1)))
    return "\n".join(lines)


def matrix(K: Array, names: Sequence[str], *heads: Sequence[str]) -> str:
    """Return a symmetric matrix with names of rows and heads of columns; round-off shown as 0.

    Parameters
    ----------
    K : symmetric matrix (n, n)
    names : names of its rows
    heads : lines of names of its columns
    """
    size = np.sqrt(np.abs(np.diag(K)))
    shown = np.where(np.abs(K) < ROUND_OFF * np.outer(size, size), 0.0, K)
    rows = [["", *head] for head in heads]
    for name, row in zip(names, shown, strict=True):
        rows.append([name, *(f"{value:.5e}" if value else "0" for value in row)])
    return aligned(rows, head=len(heads), rule=False)


def rounded(value: float, size: float, digits: int = 5) -> str:
    """Write a number; 0 if it is round-off beside `size`.

    Parameters
    ----------
    value : the number
    size : size of the terms that it is a sum of
    digits : number of digits
    """
    return "0" if abs(value) < ROUND_OFF * size else number(value, digits)


def labelled(label: str, text: str) -> str:
    """Return a line of a label and its text."""
    return f"{label:16}{text}"


def in_rows(label: str, values: Iterable[float], unit: str) -> list[str]:
    """Return lines of numbers, at most six of them in a line.

    Parameters
    ----------
    label : text before the first line
    values : the numbers
    unit : their unit
    """
    texts = [f"{value:12.6g}" for value in values]
    rows = ["".join(texts[first : first + 6]) for first in range(0, len(texts), 6)]
    return [
        labelled("" if k else label, f"{row if k else row.lstrip()} {unit}")
        for k, row in enumerate(rows)
    ]


def warning_lines(warnings: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a line for each warning of a file."""
    return [f"warning [{each['code']}] {each['message']}" for each in warnings]


def json_text(value: Any) -> str:
    """Return a value as JSON for programs and readers; NaN and infinity become null."""
    return json.dumps(plain(value, finite=True), indent=2, ensure_ascii=False, allow_nan=False)
