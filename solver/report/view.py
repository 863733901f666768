"""The section of report.html with the mechanism in motion; script/viewer.js fills it."""

from html import escape

from .elements import section

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
