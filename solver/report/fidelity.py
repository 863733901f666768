"""The section of report.html on runs with [fidelity], with the chart of their models."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

from ..math.arrays import front
from ..package.common.files import kept_table
from .report_data import Story
from .sections import Cell, Row, figures, name_of, section, table

# Chart of the models of a run with [fidelity] in the page: error against CPU time, as SVG.

WIDTH, HEIGHT = 640, 330
LEFT, RIGHT, TOP, BOTTOM = 62, 14, 14, 44
SYMBOLS = {"model": "fid-model", "chosen": "fid-chosen", "check": "fid-check"}


def chart(fidelity: Mapping[str, Any], title: str) -> str:
    """Return the chart of a ladder (plain data of `fidelity.ladder.Ladder`); "" without points.

    Models with an error of zero or without end are left out.
    """
    points = [(r["cpu"], r["error"], r["name"], "model") for r in fidelity["rungs"]]
    points += [
        (fidelity[key]["cpu"], fidelity[key]["error"], fidelity[key]["name"], key)
        for key in ("chosen", "check")
    ]
    shown = [p for p in points if p[0] > 0.0 and 0.0 < p[1] < 1e6]
    if not shown:
        return ""
    x = _Axis([p[0] for p in shown], LEFT, WIDTH - RIGHT)
    sizes = [p[1] for p in shown] + [
        v for v in (fidelity["asked"], fidelity["estimate"]) if v > 0.0
    ]
    y = _Axis(sizes, HEIGHT - BOTTOM, TOP)
    parts = [*_grid(x, y)]
    best = [shown[i] for i in front([p[:2] for p in shown])]
    line = " ".join(f"{x(p[0]):.1f},{y(p[1]):.1f}" for p in best)
    parts.append(f"<polyline class='fid-front' fill='none' points='{line}'/>")
    asked = y(fidelity["asked"])
    parts.append(_level("fid-asked", LEFT, WIDTH - RIGHT, asked))
    parts.append(
        f"<text class='fid-asked' x='{WIDTH - RIGHT - 4}' y='{asked - 4:.1f}' "
        "text-anchor='end'>asked</text>"
    )
    for cpu, error, name, kind in shown:
        parts.append(_symbol(kind, x(cpu), y(error), f"{name}: {cpu:.3g} s, error {error:.1e}"))
    if fidelity["estimate"] > 0.0 and fidelity["chosen"]["cpu"] > 0.0:
        at, height = x(fidelity["chosen"]["cpu"]), y(fidelity["estimate"])
        parts.append(_level("fid-estimate", at - 9, at + 9, height))
    label = escape(f"Error against CPU time of the models of {title}", quote=True)
    return (
        f"<svg class='fid' viewBox='0 0 {WIDTH} {HEIGHT}' role='img' aria-label='{label}'>"
        + "".join(parts)
        + "</svg>"
    )


class _Axis:
    """A logarithmic axis between two places."""

    def __init__(self, values: Iterable[float], begin: float, end: float) -> None:
        logs = [math.log10(value) for value in values]
        self.low, self.high = math.floor(min(logs) * 2) / 2, math.ceil(max(logs) * 2) / 2
        if self.high == self.low:
            self.high += 0.5
        self.begin, self.end = begin, end

    def __call__(self, value: float) -> float:
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)

    def decades(self) -> list[int]:
        """Powers of ten within the axis."""
        return list(range(math.ceil(self.low), math.floor(self.high) + 1))


def _grid(x: _Axis, y: _Axis) -> list[str]:
    low, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    lines = []
    for n in x.decades():
        at = f"{x(10.0**n):.1f}"
        lines.append(f"<line class='fid-grid' x1='{at}' x2='{at}' y1='{TOP}' y2='{low}'/>")
        lines.append(f"<text x='{at}' y='{low + 16}' text-anchor='middle'>{10.0**n:g}</text>")
    for n in y.decades():
        height = y(10.0**n)
        lines.append(_level("fid-grid", LEFT, right, height))
        lines.append(f"<text x='{LEFT - 6}' y='{height + 4:.1f}' text-anchor='end'>1e{n}</text>")
    middle = (LEFT + right) / 2
    lines.append(
        f"<text x='{middle}' y='{HEIGHT - 8}' text-anchor='middle'>CPU time of a run [s]</text>"
    )
    lines.append(
        f"<text transform='translate(14 {(TOP + low) / 2}) rotate(-90)' text-anchor='middle'>"
        "error / largest value</text>"
    )
    return lines


def _level(kind: str, x1: float, x2: float, y: float) -> str:
    return f"<line class='{kind}' x1='{x1:.1f}' x2='{x2:.1f}' y1='{y:.1f}' y2='{y:.1f}'/>"


def _symbol(kind: str, x: float, y: float, title: str) -> str:
    shapes = {
        "model": f"<circle cx='{x:.1f}' cy='{y:.1f}' r='3.5'/>",
        "chosen": f"<path d='M{x:.1f} {y - 7:.1f} l7 7 l-7 7 l-7 -7 z'/>",
        "check": f"<rect x='{x - 5:.1f}' y='{y - 5:.1f}' width='10' height='10'/>",
    }
    return f"<g class='{SYMBOLS[kind]}'><title>{escape(title)}</title>{shapes[kind]}</g>"


# The section of report.html on runs with [fidelity]: asked, model, estimate, not checked.

CHECKED = {
    "met": "met",
    "not met": "NOT met",
    "planned": "not checked",
}


def ladder_file(case_dir: Path, run: str) -> Path:
    """Return where `plymotion plan --chart` writes the models of a run."""
    return case_dir / "plans" / f"{run}.ladder.json"


def with_ladder(case_dir: Path, story: Story) -> Story:
    """Return the run with the models of `plymotion plan --chart`, if they are those of its plan.

    Otherwise, and if the file is damaged, the chart has the models that planning has tried.
    """
    fidelity = story.summary.get("fidelity")
    if fidelity is None:
        return story
    ladder = kept_table(ladder_file(case_dir, story.name))
    if not ladder or any(ladder.get(key) != fidelity.get(key) for key in ("plan", "asked")):
        return story
    return replace(story, summary={**story.summary, "fidelity": {**fidelity, "ladder": ladder}})


def fidelity_section(stories: list[Story]) -> str:
    """Return the section, "" if no run has [fidelity]."""
    planned = [story for story in stories if story.summary.get("fidelity")]
    if not planned:
        return ""
    return section(
        "fidelity",
        "Accuracy asked and estimated",
        "<p>The estimated error of the chosen model is the difference of its run from a run with "
        "more modes, another mesh and a tighter tolerance, the check. It is no bound. If the check "
        "is delivered, its error is smaller than that of the model; how much smaller is not known. "
        "Errors are relative to the scale.</p>",
        _overview(planned),
        *(_details(story) for story in planned),
    )


def _overview(stories: list[Story]) -> str:
    head = ["run", "asked", "metric", "request", "signal", "scale", "estimated error of the model"]
    head += ["delivered run", "its error at most", "CPU [s]"]
    rows: list[Row] = []
    for story in stories:
        fidelity = story.summary["fidelity"]
        for name, scale in fidelity["scale"].items():
            estimate = (fidelity["estimate"] or {}).get(name)
            delivered = fidelity.get("delivered", {"run": "", "error_at_most": {}})
            most = delivered["error_at_most"].get(name)
            rows.append(
                [
                    name_of(story),
                    figures(fidelity["asked"]),
                    escape(fidelity["metric"]),
                    CHECKED.get(fidelity["verdict"], escape(fidelity["verdict"])),
                    escape(name),
                    figures(scale),
                    "none" if estimate is None else Cell(f"{estimate:.1e}", estimate),
                    escape(delivered["run"]),
                    "not estimated" if most is None else Cell(f"{most:.1e}", most),
                    figures(sum(fidelity["cpu"].values())),
                ]
            )
    return table("Accuracy asked and estimated", head, rows)


def _details(story: Story) -> str:
    fidelity = story.summary["fidelity"]
    parts = [f"<h3>{name_of(story)}</h3>", _words(fidelity), _plan(fidelity["plan"])]
    if fidelity["shares"]:
        parts.append(_shares(fidelity["shares"]))
    if fidelity.get("ladder"):
        parts.append(chart(fidelity["ladder"], story.title))
        drawn = fidelity["ladder"]["check"]["error"] > 0.0
        richest = (
            "square: the check. Errors are differences from the richest model."
            if drawn
            else "errors are differences from the check, which is not drawn itself. "
            "<code>plymotion plan --chart</code> compares it with a richer model."
        )
        parts.append(
            "<p>Circles: models that were tried; line: their front; diamond: the chosen model, "
            f"with its estimate as a bar; {richest}</p>"
        )
    items = "".join(f"<li>{escape(text)}</li>" for text in fidelity["not_checked"])
    parts.append(f"<p>Not checked:</p><ul>{items}</ul>")
    return "\n".join(parts)


def _words(fidelity: Mapping[str, Any]) -> str:
    lines = []
    if fidelity["reason"]:
        lines.append(f"{CHECKED.get(fidelity['verdict'], '')}: {fidelity['reason']}.")
    if fidelity["base"] != "rigid":
        lines.append(f"The bodies cannot all be rigid: {fidelity['base']}.")
    if fidelity["horizon"] is not None:
        lines.append(
            f"From t = {fidelity['horizon']:.4g} s on, a change of the masses by 1e-6 has grown to "
            "the accuracy: the estimate holds for this run only."
        )
    lines += [f"{text[0].upper()}{text[1:]}." for text in fidelity.get("theories", [])]
    return "".join(f"<p>{escape(line)}</p>" for line in lines)


def _plan(plan: Mapping[str, Any]) -> str:
    head = ["body", "vibrations", "static shapes", "mesh"]
    rows: list[Row] = []
    for name, body in plan["bodies"].items():
        if not body["vibrations"] and not body["static_shapes"]:
            rows.append([escape(name), "rigid", "", ""])
            continue
        ring = "undamped" if body["ringing"] else "damped"
        shapes = f"{body['static_shapes']}, {ring}" if body["static_shapes"] else "none"
        kept = escape(", ".join(body["vibrations"]) or "none")
        rows.append([escape(name), kept, shapes, escape(body["mesh"])])
    stiffening = "on" if plan["geometric_stiffening"] else "off"
    caption = f"<p>Geometric stiffening {stiffening}, rtol = {plan['rtol']:.2g}.</p>"
    return table("Model of each body", head, rows) + caption


def _shares(shares: list[Mapping[str, Any]]) -> str:
    rows: list[Row] = [
        [escape(s["kind"]), escape(s["body"] or "all"), Cell(f"{s['value']:.1e}", s["value"])]
        for s in shares
    ]
    head = ["kind", "body", "share of the error"]
    return table("Shares of the error of the last plan that was too coarse", head, rows)
