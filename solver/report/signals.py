"""The section of report.html on the signals: final value, extremes with their times, mean."""

from html import escape
from typing import Any

from .elements import Row, figures, name_of, section, table
from .story import Story

HEAD = ["signal", "run", "unit", "final", "minimum", "at [s]", "maximum", "at [s]", "rms", "peak"]


def signals_section(stories: list[Story]) -> str:
    """Return a row for each signal and run, or nothing without signals.

    The button of a row goes to the time of the largest magnitude.
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
                    figures(found.get("t_min"), 4),
                    figures(found.get("max"), 4),
                    figures(found.get("t_max"), 4),
                    figures(found.get("rms"), 4),
                    _jump(story, name, found),
                ]
            )
    if not rows:
        return ""
    return section("signals", "Signals", table("Final values and extremes of signals", HEAD, rows))


def _jump(story: Story, name: str, found: dict[str, Any]) -> str:
    """Return a button that shows the run at the time of the largest magnitude."""
    if found.get("min") is None or found.get("max") is None:
        return ""
    time = found["t_max"] if abs(found["max"]) >= abs(found["min"]) else found["t_min"]
    return (
        f"<button type='button' class='small' data-run='{escape(story.name)}' "
        f"data-time='{float(time)!r}' aria-label='show the peak of {escape(name)}, "
        f"{escape(story.title)}'>show</button>"
    )
