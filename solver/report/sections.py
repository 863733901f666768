"""Sections of report.html on runs: status, inputs, signals, the meaning of numbers."""

import json
import re
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from ..errors import counted
from ..results.codes import RUN_CODES, Finding
from ..results.summary import findings, invalid_words, is_under_way, verdict
from .report_data import Story
from .table import measure, number

# Elements of report.html: sections, tables that can be sorted, names of runs.

_TAG = re.compile(r"<[^>]*>")
_NUMBER = re.compile(r"-?(\d[\d.]*(e[+-]?\d+)?|inf|nan)?")


class Cell(NamedTuple):
    """A cell of a table: HTML, and the number that it is sorted by."""

    html: str
    value: float | None = None


Row = Sequence[str | Cell]


def figures(value: float | None, digits: int = 3) -> Cell:
    """Return a number as a cell that is sorted by its full value."""
    return Cell(number(value, digits), value)


def section(name: str, title: str, *content: str) -> str:
    """Return a section with a heading and the anchor `name`.

    Parameters
    ----------
    name : anchor
    title : heading
    content : parts as HTML; empty ones are left out
    """
    inside = "\n".join(part for part in content if part)
    head = f"<h2 id='{name}-title'>{title}</h2>"
    return f"<section id='{name}' aria-labelledby='{name}-title'>{head}{inside}</section>"


def table(caption: str, head: Sequence[str], rows: Sequence[Row]) -> str:
    """Return a table that sorts by the column whose heading is pressed.

    `head` and the cells are HTML; a caption is for screen readers.

    Parameters
    ----------
    caption : what the table has
    head : headings of the columns
    rows : cells of each row
    """
    textual = [any(_is_text(row[k]) for row in rows) for k in range(len(head))]
    top = "".join(
        f"<th scope='col'{_side(word)}>{text}</th>"
        for text, word in zip(head, textual, strict=True)
    )
    body = "".join(f"<tr>{_cells(row, textual)}</tr>" for row in rows)
    return (
        f"<div class='scroll' tabindex='0' role='region' aria-label='{escape(caption)}'>"
        f"<table class='sortable'><caption>{escape(caption)}</caption>"
        f"<thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _cells(row: Row, textual: Sequence[bool]) -> str:
    cells = []
    for k, (item, word) in enumerate(zip(row, textual, strict=True)):
        html, value = item if isinstance(item, Cell) else (item, None)
        key = _side(word) + ("" if value is None else f" data-v='{value!r}'")
        cells.append(f"<th scope='row'{key}>{html}</th>" if k == 0 else f"<td{key}>{html}</td>")
    return "".join(cells)


def _is_text(item: str | Cell) -> bool:
    html = item.html if isinstance(item, Cell) else item
    return not _NUMBER.fullmatch(_TAG.sub("", html))


def _side(word: bool) -> str:
    """Columns of words begin at the left, those of numbers end at the right."""
    return " class='text'" if word else ""


def name_of(story: Story) -> str:
    """Return title and name of a run."""
    code = f"<code>{escape(story.name)}</code>"
    return f"{escape(story.title)}<br>{code}" if story.title != story.name else code


# The top of report.html: outcome and warnings of each run.

_RANK = {"good": 0, "doubt": 1, "bad": 2}
_WHY = {code.name: code.why for code in RUN_CODES if code.why}


def banner(stories: list[Story]) -> str:
    """Return one line on all runs, in the colour of the worst: how many completed, what stopped."""
    going = [story for story in stories if is_under_way(story.summary)]
    stopped = [story for story in stories if story.stopped and story not in going]
    worst = max((verdict(story.summary) for story in stories), key=lambda finding: _RANK[finding])
    completed = len(stories) - len(stopped) - len(going)
    parts = [f"{completed} of {counted(len(stories), 'run')} completed"]
    parts += [escape(f"{story.title}: {story.summary['message']}") for story in going]
    if stopped:
        finding = [each for story in stopped for each in findings(story.summary)]
        errors = [each.code for each in finding if each.level == "error"]
        why = ", ".join(dict.fromkeys(_WHY.get(code, code) for code in errors))
        parts.append(f"{len(stopped)} stopped early{f': {escape(why)}' if why else ''}")
    if invalid := sum(bool(invalid_words(story.summary)) for story in stories):
        parts.append(f"{invalid} completed, but invalid")
    counts = _counts([each for story in stories for each in findings(story.summary)])
    parts.append(f"<a href='#doubts'>{counts}</a>" if counts else "no warnings")
    return f"<p class='verdict {worst}'>{'; '.join(parts)}.</p>"


def outcomes(stories: list[Story]) -> str:
    """Return the table of the runs."""
    head = ["run", "outcome", "constraint violation [m]", "energy drift [-]", "modes"]
    head += ["integrator", "steps", "rejected", "evaluations", "solve [s]", "preprocess [s]"]
    rows: list[Row] = []
    for story in stories:
        checks = story.summary.get("checks", {})
        cost = story.summary.get("cost", {})
        modes = ", ".join(f"{escape(b)} {n}" for b, n in checks.get("modes_used", {}).items())
        rows.append(
            [
                name_of(story),
                _outcome(story),
                figures(checks.get("constraint_position_max"), 2),
                figures(checks.get("energy_drift_relative"), 2),
                modes or "-",
                escape(str(cost.get("integrator", "-"))),
                *(_count(cost.get(key)) for key in ("steps", "rejected", "evaluations")),
                figures(cost.get("solve_s")),
                figures(cost.get("preprocess_s")),
            ]
        )
    return section("runs", "Runs", table("Outcome and cost of the runs", head, rows))


def doubts(stories: list[Story]) -> str:
    """Return all findings by code, errors first: one line, which unfolds to those of each run."""
    doubtful = [(story, each) for story in stories for each in findings(story.summary)]
    codes = dict.fromkeys(each.code for _, each in sorted(doubtful, key=_order))
    groups = "".join(_group([pair for pair in doubtful if pair[1].code == c]) for c in codes)
    return section("doubts", "Warnings and notes", groups or "<p>None.</p>")


def _order(pair: tuple[Story, Finding]) -> int:
    return ("error", "warning", "note").index(pair[1].level)


def _group(findings_of_code: list[tuple[Story, Finding]]) -> str:
    """Return the findings of one code."""
    level = min(findings_of_code, key=_order)[1].level
    runs = list(dict.fromkeys(story.title for story, _ in findings_of_code))
    bodies = dict.fromkeys(each.body for _, each in findings_of_code if each.body)
    parts = [counted(len(runs), "run") if len(runs) > 1 else runs[0], *bodies]
    lines = "".join(_line(story, each) for story, each in findings_of_code)
    code = escape(findings_of_code[0][1].code)
    return (
        f"<details class='{level}'><summary><code>{code}</code> {level}: "
        f"{escape(', '.join(parts))}</summary><ul>{lines}</ul></details>"
    )


def _line(story: Story, finding: Finding) -> str:
    jump = ""
    if finding.t is not None:
        jump = (
            f" <button type='button' class='small' data-run='{escape(story.name)}' "
            f"data-time='{float(finding.t)!r}'>show</button>"
        )
    return f"<li><b>{escape(story.title)}</b>: {escape(finding.text)}{jump}</li>"


def _counts(findings_of_run: list[Finding]) -> str:
    """Return how many errors and warnings there are; nothing if there is none."""
    levels = [each.level for each in findings_of_run]
    return ", ".join(
        counted(levels.count(level), level) for level in ("error", "warning") if level in levels
    )


def _count(value: int | None) -> Cell:
    return Cell("-" if value is None else str(value), value)


def _outcome(story: Story) -> Cell:
    t_end = float(story.summary.get("t_end") or story.result.t[-1])
    kind, counts = verdict(story.summary), _counts(findings(story.summary))
    text = f"stopped at {t_end:.4g} s" if story.stopped else f"completed, {t_end:.4g} s"
    text = invalid_words(story.summary) or text
    badge = f"<span class='badge {kind}'>{text}</span>"
    if counts:
        badge += f"<br><a href='#doubts'>{counts}</a>"
    return Cell(badge, float(_RANK[kind]))


# The section of report.html on inputs: what differs between runs, versions, digests, command.

ALWAYS = ("solver.", "gravity")  # keys that are shown even if all runs agree
LONG = 60  # characters of a value


def inputs_section(stories: list[Story]) -> str:
    """Return parameters that differ or matter, and where the results come from."""
    flat = [_flat(story.inputs) for story in stories]
    keys = sorted({key for each in flat for key in each})
    shown = [
        key
        for key in keys
        if key.startswith(ALWAYS) or len({repr(each.get(key)) for each in flat}) > 1
    ]
    head = ["key", *(escape(story.title) for story in stories)]
    rows: list[Row] = [
        [f"<code>{escape(key)}</code>", *(_value(each.get(key)) for each in flat)] for key in shown
    ]
    parameters = table("Settings, and keys that differ between runs", head, rows) if rows else ""
    return section("inputs", "Inputs and provenance", parameters, _provenance(stories))


def _provenance(stories: list[Story]) -> str:
    rows: list[Row] = []
    for story in stories:
        provenance = story.summary.get("provenance", {})
        versions = ", ".join(f"{name} {v}" for name, v in provenance.get("versions", {}).items())
        rows.append(
            [
                escape(story.title),
                f"<code>{escape(str(story.summary.get('inputs_sha256', '-')))}</code>",
                f"<code>{escape(story.sha256)}</code>",
                escape(versions or "-"),
                f"<code>{escape(str(provenance.get('command', '-')))}</code>",
            ]
        )
    head = ["run", "SHA-256 of the inputs", "SHA-256 of result.vtkhdf", "versions", "command"]
    return f"<h3>Provenance</h3>{table('Where the results come from', head, rows)}"


def _flat(inputs: Any, prefix: str = "") -> dict[str, object]:
    """Return a nested table by dotted keys; keys without a value are left out."""
    if not isinstance(inputs, dict):
        return {} if inputs is None else {prefix: inputs}
    flat: dict[str, object] = {}
    for key, value in inputs.items():
        flat |= _flat(value, f"{prefix}.{key}" if prefix else str(key))
    return flat


def _value(value: Any) -> str:
    if value is None:
        return "-"
    text = json.dumps(value) if isinstance(value, list | bool) else str(value)
    return escape(text if len(text) <= LONG else text[: LONG - 1] + "…")


# The section of report.html on the signals: final value, extremes with their times, mean.

WORDS = {"min": "minimum", "max": "maximum"}
HEAD = ["signal", "run", "unit", "final", "minimum", "at [s]", "maximum", "at [s]", "rms"]


def signals_section(stories: list[Story]) -> str:
    """Return a row for each signal and run, or nothing without signals.

    The times of both extremes are buttons that go there: which of them is the worst depends on
    the signal, of a strength ratio the minimum.
    """
    descriptions = {s.name: s.description for story in stories for s in story.result.signals}
    barred = any("error_bars" in story.summary for story in stories)
    rows: list[Row] = []
    for name, description in descriptions.items():
        for story in stories:
            summary = story.summary.get("signals", {}).get(name)
            if summary is None:
                continue
            rows.append(
                [
                    f"{escape(description)}<br><code>{escape(name)}</code>"
                    if description
                    else escape(name),
                    name_of(story),
                    escape(summary.get("unit", "-")),
                    figures(measure(summary, "final"), 5),
                    figures(measure(summary, "min"), 4),
                    _jump(story, name, summary, "min"),
                    figures(measure(summary, "max"), 4),
                    _jump(story, name, summary, "max"),
                    figures(summary.get("rms"), 4),
                    *([figures(summary.get("error_bar"), 2)] if barred else []),
                ]
            )
    if not rows:
        return ""
    head = [*HEAD, "error bar"] if barred else HEAD
    text = table("Final values and extremes of signals", head, rows)
    if barred:
        bars = [story.summary["error_bars"] for story in stories if "error_bars" in story.summary]
        without = dict.fromkeys(what for one in bars for what in one["not_contained"])
        reasons = dict.fromkeys(one["reason"] for one in bars if one["reason"])
        notes = [f"They do not contain: {', '.join(without)}."] if without else []
        notes += [f"Bars are missing: {reason}." for reason in reasons]
        text += (
            "<p>Error bars are of tolerance, modes, stiffening, mesh and section. "
            f"{escape(' '.join(notes))}</p>"
        )
    if left_out := max(story.left_out for story in stories):
        text += (
            f"<p>{left_out} more signals are not shown; their values are in "
            "<code>result.vtkhdf</code>, their extremes in <code>summary.json</code>.</p>"
        )
    return section("signals", "Signals", text)


def _jump(story: Story, name: str, summary: Mapping[str, Any], end: str) -> str | Cell:
    """Return a button with the time of an extreme, which shows the run then."""
    time = summary.get(f"t_{end}")
    if time is None:
        return figures(None)
    shown = number(time, 4)
    label = f"{shown} s: show the {WORDS[end]} of {escape(name)}, {escape(story.title)}"
    return Cell(
        f"<button type='button' class='time' data-run='{escape(story.name)}' "
        f"data-time='{float(time)!r}' aria-label='{label}'>{shown}</button>",
        float(time),
    )


# The last section of report.html: the meaning of its numbers.

READING = """<section id='reading' class='reading'><h2>How to read this page</h2><dl>
<dt>Completed</dt><dd>The run reached its end time. A stopped run is shown up to its stop.
Its final values are those at the stop. A run is invalid from the
time at which a finding of level error says so.</dd>
<dt>Constraint violation</dt><dd>The largest distance, over the run, between points that a joint
connects.</dd>
<dt>Energy drift</dt><dd>Kinetic, strain and potential energy minus the work of drives and dampers
is constant in an exact solution. The number is its largest change, divided by the largest energy
of the run.</dd>
<dt>Solve</dt><dd>Wall time to build the model and to integrate it. Start of the program, reading,
recovery of results and writing are left out; <code>cost.seconds</code> of summary.json has
them.</dd>
<dt>Minimum, maximum, rms</dt><dd>Of a signal at the output times. A click on a time shows the
mechanism then.</dd>
<dt>Spectrum</dt><dd>Amplitude of the part of the signal in view, without its mean, with a Hann
window. A pure vibration shows its amplitude at its frequency.</dd>
<dt>Strength ratio R</dt><dd>The factor on all stresses at which the first ply fails, lowest over
points and output times. Below 1 the ply fails in this run. The exposure 1/R grows with the load.
Stresses depend on the modes of the body: use more modes and compare. Shown if
materials have strengths.</dd>
<dt>Keys</dt><dd>Space: play and pause. Left and right: one step. Home and End: first and last
time. Drag over a plot to zoom, double-click to see all again, click to go to that time.</dd>
<dt>More</dt><dd>The folder of each run has <code>summary.json</code> (these numbers for
programs) and <code>result.vtkhdf</code>. In ParaView apply the filter <em>Warp By Vector</em>
with the array <em>displacement</em>, then press play. <code>plymotion report FOLDER
--figures</code> draws the plots as PNG files, <code>--glb</code> writes the animation for Blender
and slides, <code>--vtk</code> for ParaView with sections and strength ratios.</dd></dl>
</section>"""
