"""The section of report.html on the signals: final value, extremes with their times, mean."""

from html import escape
from typing import Any

from .elements import Cell, Row, figures, name_of, section, table
from .story import Story
from .table import number

WORDS = {"min": "minimum", "max": "maximum"}
HEAD = ["signal", "run", "unit", "final", "minimum", "at [s]", "maximum", "at [s]", "rms"]


def signals_section(stories: list[Story]) -> str:
    """Return a row for each signal and run, or nothing without signals.

    The times of both extremes are buttons that go there: which of them is the worst depends on
    the signal, of a strength ratio the minimum.
    """
    descriptions = {s.name: s.description for story in stories for s in story.result.signals}
    rows: list[Row] = []
    for name, words in descriptions.items():
        for story in stories:
            found = story.summary.get("signals", {}).get(name)
            if found is None:
                continue
            rows.append(
                [
                    f"{escape(words)}<br><code>{escape(name)}</code>" if words else escape(name),
                    name_of(story),
                    escape(found.get("unit", "-")),
                    figures(found.get("final"), 5),
                    figures(found.get("min"), 4),
                    _jump(story, name, found, "min"),
                    figures(found.get("max"), 4),
                    _jump(story, name, found, "max"),
                    figures(found.get("rms"), 4),
                ]
            )
    if not rows:
        return ""
    found = table("Final values and extremes of signals", HEAD, rows)
    if left_out := max(story.left_out for story in stories):
        found += (
            f"<p>{left_out} more signals are not shown; their values are in "
            "<code>result.vtkhdf</code>, their extremes in <code>summary.json</code>.</p>"
        )
    return section("signals", "Signals", found)


def _jump(story: Story, name: str, found: dict[str, Any], end: str) -> str | Cell:
    """Return a button with the time of an extreme, which shows the run then."""
    time = found.get(f"t_{end}")
    if time is None:
        return figures(None)
    shown = number(time, 4)
    words = f"{shown} s: show the {WORDS[end]} of {escape(name)}, {escape(story.title)}"
    return Cell(
        f"<button type='button' class='time' data-run='{escape(story.name)}' "
        f"data-time='{float(time)!r}' aria-label='{words}'>{shown}</button>",
        float(time),
    )
