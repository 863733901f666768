"""report.html: one self-contained page, without other files or network."""

from html import escape
from pathlib import Path
from typing import Any

from .elements import figure, name_of, table
from .story import Story
from .strength import fatigue_section, strength_section
from .table import number, signal_numbers

_CSS = (Path(__file__).parent / "page.css").read_text(encoding="utf-8")


def page(
    title: str,
    stories: list[Story],
    comparisons: list[tuple[str, Path]],
    motions: list[Path],
    balances: list[Path],
    strengths: list[Path],
) -> str:
    """Return the page as HTML; figures are embedded.

    `strengths` has one figure for each story with strength results, the other lists one for each
    story.
    """
    done = sum(not story.stopped for story in stories)
    count = f"{done} of {len(stories)} runs completed"
    parts = [
        f"<header><h1>{escape(title)}</h1><p>{count}.</p></header>",
        "<section><h2>Runs</h2>",
        _outcomes(stories),
        "</section><section><h2>Signals</h2>",
        _signals(stories),
        "</section>",
        _warnings(stories),
        "<section><h2>Comparison</h2>",
        *(figure(path, caption, "wide") for caption, path in comparisons),
        "</section><section><h2>Motion</h2><div class='grid'>",
        *(figure(p, f"Motion of {s.title}") for s, p in zip(stories, motions, strict=True)),
        "</div></section>",
        strength_section(stories, strengths),
        fatigue_section(stories),
        "<section><h2>Verification</h2><div class='grid'>",
        *(figure(p, f"Balance of {s.title}") for s, p in zip(stories, balances, strict=True)),
        "</div></section>",
        _READING,
    ]
    return (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>{escape(title)}</title><style>{_CSS}</style></head>\n<body><main>"
        + "\n".join(parts)
        + "</main></body></html>\n"
    )


def _outcome(story: Story) -> str:
    t_end = f"{number(story.summary.get('t_end'), 4)} s"
    if story.stopped:
        badge = f"<span class='badge bad'>stopped at {t_end}</span>"
    else:
        badge = f"<span class='badge good'>completed, {t_end}</span>"
    count = len(story.summary.get("warnings", []))
    if count:
        words = "1 warning" if count == 1 else f"{count} warnings"
        badge += f"<br><a href='#warnings-{escape(story.name)}'>{words}</a>"
    return badge


def _outcomes(stories: list[Story]) -> str:
    head = ["run", "outcome", "constraint<br>violation [m]", "energy<br>drift [-]", "modes"]
    head += ["integrator", "steps", "solve<br>[s]", "preprocess<br>[s]"]
    rows = []
    for story in stories:
        checks: dict[str, Any] = story.summary.get("checks", {})
        cost: dict[str, Any] = story.summary.get("cost", {})
        modes = ", ".join(f"{escape(b)} {n}" for b, n in checks.get("modes_used", {}).items())
        rows.append(
            [
                name_of(story),
                _outcome(story),
                number(checks.get("constraint_position_max"), 2),
                number(checks.get("energy_drift_relative"), 2),
                modes or "-",
                escape(str(cost.get("integrator", "-"))),
                str(cost.get("steps", "-")),
                number(cost.get("solve_s")),
                number(cost.get("preprocess_s")),
            ]
        )
    return table("".join(f"<th>{cell}</th>" for cell in head), rows)


def _signals(stories: list[Story]) -> str:
    units = {s.name: s.unit for story in stories for s in story.result.signals}
    top = "<th rowspan='2'>run</th>"
    for name, unit in units.items():
        top += f"<th colspan='2'>{escape(name)} [{escape(unit)}]</th>"
    below = "<th>final</th><th>largest</th>" * len(units)
    rows = []
    for story in stories:
        row = [name_of(story)]
        for name in units:
            row += signal_numbers(story.summary.get("signals", {}).get(name, {}))
        rows.append(row)
    return table(f"{top}</tr><tr class='below'>{below}", rows)


def _warnings(stories: list[Story]) -> str:
    items = []
    for story in stories:
        messages = story.summary.get("warnings", [])
        if not messages:
            continue
        lines = "".join(
            f"<li><code>{escape(w['code'])}</code> {escape(w['message'])}</li>" for w in messages
        )
        anchor = f"warnings-{escape(story.name)}"
        items.append(f"<h3 id='{anchor}'>{escape(story.title)}</h3><ul>{lines}</ul>")
    if not items:
        return "<section><h2>Warnings</h2><p>None.</p></section>"
    return f"<section class='warnings'><h2>Warnings</h2>{''.join(items)}</section>"


_READING = """<section class='reading'><h2>How to read this page</h2><dl>
<dt>Completed</dt><dd>The run reached its end time. A stopped run is drawn up to its stop,
which is marked in red. Its final values are those at the stop.</dd>
<dt>Constraint violation</dt><dd>The largest distance, over the run, between points that a joint
connects.</dd>
<dt>Energy drift</dt><dd>Kinetic, strain and potential energy minus the work of drives and dampers
is constant in an exact solution. The number is its largest change, divided by the largest energy
of the run.</dd>
<dt>Solve</dt><dd>Wall time to build the model and to integrate it. Start of the program, reading,
recovery of results and writing are left out; <code>cost.seconds</code> of summary.json has
them.</dd>
<dt>Largest</dt><dd>The largest magnitude of a signal at the output times.</dd>
<dt>Strength ratio R</dt><dd>The factor on all stresses at which the first ply fails, lowest over
points and output times. Below 1 the ply fails in this run. The exposure 1/R grows with the load.
Stresses depend on the modes of the body: use more modes and compare. Shown if
materials have strengths.</dd>
<dt>More</dt><dd>The folder of each run has <code>summary.json</code> (these numbers for programs)
and <code>result.vtkhdf</code>. In ParaView apply the filter <em>Warp By Vector</em> with the array
<em>displacement</em>, then press play.</dd></dl></section>"""
