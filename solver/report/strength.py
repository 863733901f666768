"""The section of report.html on the strength of plies."""

from html import escape
from pathlib import Path
from typing import Any

from .elements import figure, name_of, table
from .story import Story
from .table import number

PLIES_SHOWN = 5  # of each body


def strength_section(stories: list[Story], figures: list[Path]) -> str:
    """Return the section on ply stresses, or nothing if no material has strengths."""
    told = [story for story in stories if story.summary.get("strength")]
    if not told:
        return ""
    bodies = [(s, body, found) for s in told for body, found in s.summary["strength"].items()]
    weakest = [
        (story, body, found)
        for story, body, whole in bodies
        for found in whole.get("plies", [])[:PLIES_SHOWN]
    ]
    tables = _rows(bodies)
    if len(weakest) > len(bodies):
        tables += f"<h3>Weakest plies of each body</h3>{_rows(weakest)}"
    drawn = "".join(
        figure(path, f"Exposure along the beams of {story.title}")
        for story, path in zip(told, figures, strict=True)
    )
    return f"<section><h2>Strength</h2>{tables}<div class='grid'>{drawn}</div></section>"


def _rows(found: list[tuple[Story, str, dict[str, Any]]]) -> str:
    """Return a table of lowest strength ratios: story, body, entry of summary.json."""
    head = ["run", "body", "strength<br>ratio R [-]", "margin<br>R - 1 [-]", "criterion", "mode"]
    head += ["x<br>[m]", "time<br>[s]", "ply"]
    rows = []
    for story, body, entry in found:
        ply = entry["ply"]
        ratio = number(entry["ratio"], 4)
        rows.append(
            [
                name_of(story),
                escape(body),
                f"<span class='badge bad'>{ratio}</span>" if fails(entry) else ratio,
                number(entry["margin"], 3),
                escape(entry["criterion"]),
                escape(entry["mode"]),
                number(entry["x"], 4),
                number(entry["time"], 4),
                escape(
                    f"{ply['region']} {ply['index']}, {ply['material']}, {ply['angle_deg']:g} deg"
                ),
            ]
        )
    return table("".join(f"<th>{cell}</th>" for cell in head), rows)


def fails(found: dict[str, Any]) -> bool:
    """True if a ply of a body fails, from its entry in summary.json."""
    return found["ratio"] is not None and found["ratio"] < 1.0


def fatigue_section(stories: list[Story]) -> str:
    """Return the section on Miner sums, or nothing if no stress has an S-N line."""
    head = ["run", "stress", "Miner sum<br>of the run [-]", "runs to<br>failure [-]"]
    head += ["cycles", "largest<br>range [Pa]"]
    rows = [
        [
            name_of(story),
            escape(signal),
            number(found["damage"], 4),
            number(found["repetitions"], 4),
            number(found["cycles"], 6),
            number(found["largest_range"], 4),
        ]
        for story in stories
        for signal, found in story.summary.get("fatigue", {}).items()
    ]
    if not rows:
        return ""
    shown = table("".join(f"<th>{cell}</th>" for cell in head), rows)
    return f"<section><h2>Fatigue</h2>{shown}</section>"
