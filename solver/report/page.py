"""report.html: one self-contained page, without other files or network."""

from html import escape
from typing import Any

from .elements import section
from .embed.blob import Blob, json_for_script
from .embed.frames import NUMBERS
from .embed.histories import NUMBERS as HISTORIES
from .embed.histories import histories
from .embed.inline import policy, script, style
from .embed.scene import scene
from .inputs import inputs_section
from .modes import masses_section, modes_section
from .reading import READING
from .signals import signals_section
from .status import banner, doubts, outcomes
from .story import Comparison, Story
from .strength import fatigue_section, strength_section, worst
from .view import view

LIMIT = 2_900_000  # bytes of a page that can be mailed


def page(title: str, stories: list[Story], comparisons: list[Comparison]) -> str:
    """Return the page as HTML; the data of all plots and of the animation are embedded.

    Longer histories keep their extremes only; runs that do not fit into LIMIT have no animation.
    """
    blob = Blob()
    runs = [_run(blob, story, HISTORIES // len(stories)) for story in stories]
    index = {
        "title": title,
        "case": stories[0].result.case,
        "runs": runs,
        "figures": [c._asdict() for c in comparisons],
    }
    before = [_header(title, stories), "<main>", outcomes(stories), doubts(stories)]
    after = [
        section("plots", "Plots", "<div id='plot-list'></div>"),
        strength_section(stories),
        fatigue_section(stories),
        signals_section(stories),
        modes_section(stories),
        masses_section(stories),
        inputs_section(stories),
        READING,
        "</main>",
    ]
    head = (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        f'<meta http-equiv="Content-Security-Policy" content="{policy()}">'
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>{escape(title)}</title><style>{style()}</style></head>\n<body>"
    )
    end = f"<script>{script()}</script></body></html>\n"

    def whole(moving: str) -> str:
        arrays = json_for_script(index | {"arrays": blob.index})
        return (
            head
            + "\n".join([*before, moving, *after])
            + f"<script type='application/json' id='index'>{arrays}</script>"
            + f"<script type='text/plain' id='arrays'>{blob.text()}</script>"
            + end
        )

    still = len(whole(view([story.title for story in stories])).encode("utf-8"))
    left_out = _animate(blob, stories, runs, LIMIT - still)
    return whole(view(left_out) if any(run["scene"] for run in runs) else "")


def _animate(blob: Blob, stories: list[Story], runs: list[dict[str, Any]], room: int) -> list[str]:
    """Give an animation to the first runs, as many as fit into `room` bytes.

    Returns the titles of the others.
    """
    empty = len(blob.text())
    told = 0
    for k, (story, run) in enumerate(zip(stories, runs, strict=True)):
        undo, known = blob.mark(), len(blob.index)
        run["scene"] = scene(blob, story, NUMBERS // len(stories))
        told += len(json_for_script([run["scene"], blob.index[known:]]))
        if told + len(blob.text()) - empty > room:
            undo()
            run["scene"] = None
            return [each.title for each in stories[k:]]
    return []


def _header(title: str, stories: list[Story]) -> str:
    return (
        f"<header><div><h1>{escape(title)}</h1>{banner(stories)}</div>"
        "<div class='tools'><button type='button' id='theme'>dark</button>"
        "<button type='button' id='print'>print</button></div>"
        "<noscript><p>Plots and animation need JavaScript. The tables below are complete; "
        "<code>plymotion report FOLDER --figures</code> draws the plots as PNG files.</p>"
        "</noscript></header>"
    )


def _run(blob: Blob, story: Story, share: int) -> dict[str, Any]:
    """Return what the page needs of a run, without animation; `share` as of `histories`."""
    return {
        "name": story.name,
        "title": story.title,
        "stopped": story.stopped,
        **histories(blob, story.result, share),
        "scene": None,
        "worst": worst(story),
    }
