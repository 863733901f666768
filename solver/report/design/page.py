"""Studies of a design in the report: before and after, lay-ups, what helps most, history."""

import json
from collections.abc import Mapping, Sequence
from html import escape
from math import cos, radians, sin
from pathlib import Path
from typing import Any

from ...package.common.files import write_text
from ..inline import document
from ..sections import Row, section, table
from ..style import COLOURS, GREY, INK
from ..table import number

RESULT, PAGE = "design.json", "design.html"
ACTIVE = 1e-3  # distance from a limit, relative, below which it is active
STACK, PLY, MOST = 150, 22, 40  # width, height of a ply [px]; plies that are drawn
ROOM = 150  # beside a ply, for its angle and thickness
WIDE, HIGH = 480, 160  # of the history [px]


def study_files(case_dir: Path) -> list[Path]:
    """Return the results of the studies of a case."""
    return sorted((case_dir / "studies").glob(f"*/{RESULT}"))


def design_sections(case_dir: Path) -> list[str]:
    """Return a section of the report for each study of a case."""
    return [
        study_section(json.loads(file.read_text(encoding="utf-8")))
        for file in study_files(case_dir)
    ]


def write_page(folder: Path, study: Mapping[str, Any]) -> Path:
    """Write the page of a study into its folder; return its path."""
    title = f"{study['case_title']}: {study['title']}"
    body = f"<header><h1>{escape(title)}</h1></header><main>{study_section(study)}</main>"
    write_text(folder / PAGE, document(title, body))
    return folder / PAGE


def study_section(study: Mapping[str, Any]) -> str:
    """Return the section of a study, from the content of design.json."""
    best, shown = study["optimum"], study["optimum"]["shown"]
    verified = study.get("verified", {}).get("shown")
    rows: list[Row] = []
    for k, measure in enumerate(study["measures"]):
        unit = f" [{measure['unit']}]" if measure["unit"] else ""
        title = f"{study['sense']} {measure['words']}" if k == 0 else measure["words"]
        before = study["start"]["shown"]
        limits = [("&gt;=", measure["least"], 1.0), ("&lt;=", measure["most"], -1.0)]
        texts = [
            f"{words_of} {value:g}{_state(sign * (shown[k] - value), value)}"
            for words_of, value, sign in limits
            if value is not None
        ]
        rows.append(
            [
                escape(title + unit),
                number(before[k] if before else None, 5),
                number(shown[k], 5),
                number(verified[k] if verified else None, 5),
                ", ".join(texts),
            ]
        )
    head = ["quantity", "start", "best", "verified, richer model", "limit"]
    own = [
        [
            escape(name) + f" [{q['unit']}]" * bool(q.get("unit")),
            escape(q["names"][round(p)]) if q.get("names") else number(p, 5),
            escape(value) if q.get("names") else number(value, 5),
            escape(", ".join(q["targets"])),
        ]
        for (name, value), p, q in zip(
            best["values"].items(), study["start"]["p"], study["parameters"].values(), strict=True
        )
    ]
    doubt = ""
    if study.get("verified", {}).get("why"):
        doubt = f"<p class='note'>Not verified: {escape(study['verified']['why'])}</p>"
    return section(
        f"study-{escape(study['study'])}",
        f"Design: {escape(study['title'])}",
        table("Quantities of the study", head, rows),
        doubt,
        table("Parameters", ["parameter", "start", "best", "keys"], own),
        _stacks(study["layups"]),
        _arrows(study),
        _history(study),
        _front(study),
        f"<p class='note'>Derivatives: {escape(study['gradient'])}.</p>",
    )


def _state(inside: float, limit: float) -> str:
    """Return what is said of a limit, from which a value is inside by so much."""
    near = ACTIVE * (abs(limit) or 1.0)
    return " (not met)" if inside < -near else " (active)" if inside <= near else ""


def _text(x: float, y: float, text: str, anchor: str = "start", colour: str = INK) -> str:
    return (
        f"<text x='{x:.1f}' y='{y:.1f}' font-size='12' fill='{colour}' "
        f"text-anchor='{anchor}'>{escape(text)}</text>"
    )


def _picture(width: float, height: float, name: str, parts: Sequence[str]) -> str:
    return (
        f"<svg viewBox='0 0 {width:.0f} {height:.0f}' width='{width:.0f}' height='{height:.0f}' "
        f"role='img' aria-label='{escape(name)}'>"
        f"<rect width='{width:.0f}' height='{height:.0f}' fill='#ffffff'/>{''.join(parts)}</svg>"
    )


def _stacks(layups: Sequence[Mapping[str, Any]]) -> str:
    """Return pictures of lay-ups: plies in the order of the description, before and after."""
    stacks = []
    for layup in layups:
        plies = len(layup["after"]["angles_deg"][:MOST])
        parts = [_text(10, 16, layup["name"])]
        thicker = layup["before"]["thicknesses"] != layup["after"]["thicknesses"]
        for column, which in enumerate(("before", "after")):
            x = 10 + column * (STACK + ROOM)
            parts.append(_text(x, 34, which, colour=GREY))
            for k, angle in enumerate(layup[which]["angles_deg"][:MOST]):
                thickness = f", {1e3 * layup[which]['thicknesses'][k]:.3g} mm" if thicker else ""
                parts.append(_ply(x, 40 + k * PLY, float(angle), thickness))
        stacks.append(
            _picture(2 * (STACK + ROOM) + 10, 50 + plies * PLY, f"Lay-up of {layup['name']}", parts)
        )
    return f"<h3>Lay-ups</h3>{''.join(stacks)}" if stacks else ""


def _ply(x: float, y: float, angle: float, thickness: str) -> str:
    """Return a bar with lines along the fibres, seen from above, angle and thickness beside it."""
    c, s, middle, lines = cos(radians(angle)), sin(radians(angle)), y + 0.5 * (PLY - 3), []
    half = 0.5 * (PLY - 3)
    for k in range(1, 10):
        at = x + k * STACK / 10
        reach = min(half / abs(s) if abs(s) > 0.05 else 6.0, 6.0 if abs(c) > 0.95 else half)
        lines.append(
            f"<line x1='{at - reach * c:.1f}' y1='{middle + reach * s:.1f}' "
            f"x2='{at + reach * c:.1f}' y2='{middle - reach * s:.1f}' stroke='{INK}'/>"
        )
    hue = (2.0 * angle) % 360.0
    return (
        f"<rect x='{x}' y='{y}' width='{STACK}' height='{PLY - 3}' fill='hsl({hue:.0f},60%,82%)'/>"
        f"{''.join(lines)}{_text(x + STACK + 6, y + 14, f'{angle:.4g} deg{thickness}')}"
    )


def _arrows(study: Mapping[str, Any]) -> str:
    """Return arrows: what a parameter does for the objective, over its range; right: more of it."""
    parts, y = list[str](), 20.0
    sign = -1.0 if study["sense"] == "minimise" else 1.0
    names = list(study["parameters"])
    spans = [q["range"][1] - q["range"][0] for q in study["parameters"].values()]
    for which in ("start", "optimum"):
        slopes = study["sensitivities"][which]
        if not slopes:
            continue
        effects = [sign * d * span for d, span in zip(slopes[0], spans, strict=True)]
        largest = max(map(abs, effects)) or 1.0
        parts.append(_text(10, y, f"at the {which}", colour=GREY))
        y += 20.0
        order = sorted(range(len(names)), key=lambda k: -abs(effects[k]))
        for k in order[:12]:
            length = 150.0 * effects[k] / largest
            colour, tip = COLOURS[0 if length > 0 else 1], 240.0 + length
            back = tip - (6.0 if length > 0 else -6.0)
            parts.append(
                f"<line x1='240' y1='{y - 4:.1f}' x2='{tip:.1f}' y2='{y - 4:.1f}' "
                f"stroke='{colour}' stroke-width='3'/>"
                f"<path d='M{tip:.1f} {y - 4:.1f} L{back:.1f} {y - 9:.1f} v10 Z' "
                f"fill='{colour}'/>{_text(10, y, names[k])}{_text(410, y, f'{slopes[0][k]:.3g}')}"
            )
            y += 18.0
        y += 8.0
    if not parts:
        return ""
    note = (
        "<p class='note'>Arrows: change of the objective for the better, to the right if the "
        "parameter grows; their length is the derivative times the range of the parameter. The "
        "number is the derivative of the objective.</p>"
    )
    return f"<h3>What helps most</h3>{note}{_picture(520, y, 'What helps most', parts)}"


def _history(study: Mapping[str, Any]) -> str:
    """Return the objective over the iterations of all starts, faint where a limit is not met."""
    lines = [start["history"] for start in study["starts"]]
    values = [p["shown"][0] for line in lines for p in line]
    if len(values) < 2:
        return ""
    low, high, longest = min(values), max(values), max(map(len, lines))
    size, steps = (high - low) or 1.0, max(longest - 1, 1)
    parts = [
        _text(10, 14, number(high, 4)),
        _text(10, HIGH + 10, number(low, 4)),
        _text(WIDE - 10, HIGH + 28, f"iteration {steps}", "end"),
    ]
    for k, line in enumerate(lines):
        points = [
            f"{70 + (WIDE - 80) * i / steps:.1f},{10 + HIGH * (high - p['shown'][0]) / size:.1f}"
            for i, p in enumerate(line)
        ]
        valid = [at for at, p in zip(points, line, strict=True) if p["violation"] <= ACTIVE]
        of = f"fill='none' stroke-linecap='round' stroke='{COLOURS[k % len(COLOURS)]}'"
        parts.append(f"<polyline points='{' '.join(points)}' {of} stroke-opacity='0.3'/>")
        if valid:  # the last one twice: a single one is a dot
            ends = " ".join([*valid, valid[-1]])
            parts.append(f"<polyline points='{ends}' {of} stroke-width='2'/>")
    note = "<p class='note'>Strong lines: designs within all limits. Faint: all designs.</p>"
    return f"<h3>History of all starts</h3>{note}{_picture(WIDE, HIGH + 36, 'History', parts)}"


def _front(study: Mapping[str, Any]) -> str:
    """Return the designs of which none is better in both numbers of a study with `front`."""
    points = [(point["shown"][-1], point["shown"][0]) for point in study.get("front", [])]
    if len(points) < 2:
        return ""
    names = [f"{m['words']} [{m['unit']}]" for m in study["measures"]]
    (left, low), (right, high) = (tuple(map(f, zip(*points, strict=True))) for f in (min, max))
    width, height = (right - left) or 1.0, (high - low) or 1.0
    parts = [
        _text(10, 14, f"{number(high, 4)}  {names[0]}"),
        _text(10, HIGH + 10, number(low, 4)),
        _text(70, HIGH + 28, number(left, 4)),
        _text(WIDE - 10, HIGH + 28, f"{names[-1]}  {number(right, 4)}", "end"),
    ]
    for x, y in points:
        a, b = 70 + (WIDE - 80) * (x - left) / width, 20 + (HIGH - 20) * (high - y) / height
        parts.append(f"<circle cx='{a:.1f}' cy='{b:.1f}' r='3' fill='{COLOURS[0]}'/>")
    note = "<p class='note'>Designs within all limits of which none is better in both numbers.</p>"
    picture = _picture(WIDE, HIGH + 36, "Pareto front", parts)
    return f"<h3>Pareto front</h3>{note}{picture}"
