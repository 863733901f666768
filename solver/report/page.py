"""report.html: one self-contained page, without other files or network."""

from html import escape
from typing import Any

from .elements import Row, name_of, section, table
from .embed.blob import Blob, json_for_script
from .embed.frames import NUMBERS
from .embed.histories import NUMBERS as HISTORIES
from .embed.histories import histories
from .embed.inline import policy, script, style
from .embed.scene import scene
from .fidelity import fidelity_section
from .inputs import inputs_section
from .modes import masses_section, modes_section
from .reading import READING
from .status import banner, doubts, outcomes
from .story import Comparison, Story
from .strength import fatigue_section, strength_section, worst
from .table import signal_numbers
from .view import view

LIMIT = 2_900_000  # bytes of a page that can be mailed


def page(title: str, stories: list[Story], comparisons: list[Comparison]) -> str:
    """Return the page as HTML; the data of all plots and of the animation are embedded.

    Longer histories keep their extremes only; runs that do not fit into LIMIT have no animation.
    """
    moving = len(stories)
    while True:
        text = _page(title, stories, comparisons, moving)
        if len(text) < LIMIT or not moving:
            return text
        moving //= 2


def _page(title: str, stories: list[Story], comparisons: list[Comparison], moving: int) -> str:
    """Return the page with the animation of the first `moving` runs."""
    blob = Blob()
    index = _index(blob, title, stories, comparisons, moving)
    left_out = [story.title for story in stories[moving:]]
    parts = [
        _header(title, stories),
        "<main>",
        outcomes(stories),
        doubts(stories),
        view(left_out) if any(run["scene"] for run in index["runs"]) else "",
        section("plots", "Plots", "<div id='plot-list'></div>"),
        fidelity_section(stories),
        strength_section(stories),
        fatigue_section(stories),
        _signals(stories),
        modes_section(stories),
        masses_section(stories),
        inputs_section(stories),
        READING,
        "</main>",
    ]
    return (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        f'<meta http-equiv="Content-Security-Policy" content="{policy()}">'
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>{escape(title)}</title><style>{style()}</style></head>\n<body>"
        + "\n".join(parts)
        + f"<script type='application/json' id='index'>{json_for_script(index)}</script>"
        + f"<script type='text/plain' id='arrays'>{blob.text()}</script>"
        + f"<script>{script()}</script></body></html>\n"
    )


def _header(title: str, stories: list[Story]) -> str:
    return (
        f"<header><div><h1>{escape(title)}</h1>{banner(stories)}</div>"
        "<div class='tools'><button type='button' id='theme'>dark</button>"
        "<button type='button' id='print'>print</button></div>"
        "<noscript><p>Plots and animation need JavaScript. The tables below are complete, and the "
        "folder of the case has the figures as PNG files.</p></noscript></header>"
    )


def _index(
    blob: Blob, title: str, stories: list[Story], comparisons: list[Comparison], moving: int
) -> dict[str, Any]:
    share = HISTORIES // len(stories)
    runs = [
        {
            "name": story.name,
            "title": story.title,
            "stopped": story.stopped,
            **histories(blob, story.result, share),
            "scene": scene(blob, story, NUMBERS // len(stories)) if k < moving else None,
            "worst": worst(story),
        }
        for k, story in enumerate(stories)
    ]
    return {
        "title": title,
        "case": stories[0].result.case,
        "runs": runs,
        "figures": [c._asdict() for c in comparisons],
        "arrays": blob.index,
    }


def _signals(stories: list[Story]) -> str:
    units = {s.name: s.unit for story in stories for s in story.result.signals}
    head = ["run"]
    for name, unit in units.items():
        label = f"{escape(name)} [{escape(unit)}]"
        head += [f"{label}<br>final", f"{label}<br>largest"]
    rows: list[Row] = []
    for story in stories:
        row: list[Any] = [name_of(story)]
        for name in units:
            row += signal_numbers(story.summary.get("signals", {}).get(name, {}))
        rows.append(row)
    return section("signals", "Signals", table("Final and largest values of signals", head, rows))
