"""Summaries as aligned text for the screen."""

from collections.abc import Sequence
from typing import Any

from ..results.verdict import verdict


def summary_table(summaries: list[dict[str, Any]]) -> str:
    """Return two aligned tables: outcome of the runs, and values of their signals."""
    if not summaries:
        return "no runs"
    head = ["run", "completed", "t_end", "violation", "energy drift", "steps", "solve", "warnings"]
    units = ["", "", "[s]", "[m]", "[-]", "", "[s]", ""]
    runs = [head, units, *([s["run"], *_outcome(s)] for s in summaries)]
    names = {n: t.get("unit", "") for s in summaries for n, t in s.get("signals", {}).items()}
    top, below = ["run"], [""]
    for name, unit in names.items():
        top += [f"{name} [{unit}]", ""]
        below += ["final", "max |.|"]
    signals = [top, below]
    for summary in summaries:
        row = [summary["run"]]
        for name in names:
            row += list(signal_numbers(summary.get("signals", {}).get(name, {})))
        signals.append(row)
    tables = [aligned(runs, left=(0, 7))]
    if names:
        tables.append(aligned(signals, left=(0,)))
    return "\n\n".join(tables)


def signal_numbers(signal: dict[str, Any]) -> tuple[str, str]:
    """Return final value and largest magnitude as text."""
    ends = [abs(signal[key]) for key in ("min", "max") if signal.get(key) is not None]
    return number(signal.get("final"), 5), number(max(ends) if ends else None, 4)


def number(value: float | None, digits: int = 3) -> str:
    """Write a number with some significant digits; a dash for none."""
    return "-" if value is None else f"{value:.{digits}g}"


def warning_codes(summary: dict[str, Any]) -> list[str]:
    """Return the codes of the warnings, each once, with its count."""
    codes = [w["code"] for w in summary.get("warnings", [])]
    return [f"{c} x{codes.count(c)}" if codes.count(c) > 1 else c for c in dict.fromkeys(codes)]


def _outcome(summary: dict[str, Any]) -> list[str]:
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


def aligned(rows: Sequence[Sequence[str]], left: tuple[int, ...]) -> str:
    """Return rows of cells as lines of equal columns; `left`: columns aligned to the left."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    # The name of a signal may extend over both of its columns.
    for i, text in enumerate(rows[0][:-1]):
        if text and not rows[0][i + 1]:
            own = max(len(row[i]) for row in rows[1:])
            widths[i] = max(own, len(text) - 2 - widths[i + 1])
    lines = []
    for k, row in enumerate(rows):
        cells, i = [], 0
        while i < len(row):
            spans = k == 0 and i + 1 < len(row) and row[i] and not row[i + 1]
            width = widths[i] + 2 + widths[i + 1] if spans else widths[i]
            cells.append(row[i].ljust(width) if i in left else row[i].rjust(width))
            i += 2 if spans else 1
        lines.append("  ".join(cells).rstrip())
        if k == 1:
            lines.append("-" * (sum(widths) + 2 * (len(widths) - 1)))
    return "\n".join(lines)
