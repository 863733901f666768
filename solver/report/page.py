"""report.html: one self-contained page, without other files or network."""

from html import escape
from typing import Any

from .bodies import fatigue_section, masses_section, modes_section, strength_section, worst
from .embed.inline import NUMBERS as HISTORIES
from .embed.inline import Blob, histories, json_for_script, policy, script, style
from .embed.scene import NUMBERS, scene
from .fidelity import fidelity_section
from .sections import READING, banner, doubts, inputs_section, outcomes, section, signals_section
from .story import Comparison, Story

# The section of report.html with the mechanism in motion; script/viewer.js fills it.

_COLOURS = """<label>colour <select id='colour'>
<option value='body'>body</option><option value='displacement'>displacement</option>
<option value='energy'>strain energy</option><option value='exposure'>ply exposure 1/R</option>
</select></label>"""
_SCALES = "".join(f"<option>{scale}</option>" for scale in (1, 2, 5, 10, 20, 50, 100))
_SPEEDS = "".join(
    f"<option value='{speed}'{' selected' if speed == 1 else ''}>{speed:g}x</option>"
    for speed in (0.001, 0.01, 0.1, 0.25, 0.5, 1, 2, 5)
)

_VIEW = (
    "<div class='tools'>"
    "<label>run <select id='view-run'></select></label>"
    "<label>over it <select id='view-over'><option value=''>none</option></select></label>"
    f"{_COLOURS}"
    f"<label>deformation <select id='scale'>{_SCALES}</select></label>"
    "<label>mode <select id='solo'><option value='-1'>all</option></select></label>"
    "<label><input type='checkbox' id='edges' checked> edges</label>"
    "<button type='button' id='worst'>worst ply</button>"
    "<button type='button' id='home'>home</button></div>"
    "<div id='stage'><canvas id='canvas' tabindex='0' role='img' "
    "aria-label='The mechanism in motion. Drag to turn, wheel to zoom.'></canvas>"
    "<div id='caption' role='status'></div><div id='legend'></div></div>"
    "<div class='tools timeline'><button type='button' id='play'>play</button>"
    "<input type='range' id='slider' min='0' max='1' step='any' value='0' aria-label='time'>"
    "<output id='clock'>0 s</output>"
    f"<label>speed <select id='speed'>{_SPEEDS}</select></label></div>"
)


def view(left_out: list[str]) -> str:
    """Return the section; `left_out` are titles of runs without animation, for lack of space."""
    names = escape(", ".join(left_out))
    note = f"<p class='note'>Without animation, to keep the page small: {names}.</p>"
    return section("view", "Motion", _VIEW, note if left_out else "")


# report.html: one self-contained page, without other files or network.

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
    before = [_header(title, stories), "<main>"]
    after = [
        section("plots", "Plots", "<div id='plot-list'></div>"),
        strength_section(stories),
        fatigue_section(stories),
        signals_section(stories),
        doubts(stories),
        outcomes(stories),
        fidelity_section(stories),
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
