"""The section of report.html on runs with [fidelity]: asked, model, estimate, not checked."""

import json
from collections.abc import Mapping
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

from .elements import Cell, Row, figures, name_of, section, table
from .ladder import chart
from .story import Story

CHECKED = {
    "met": "met",
    "not met": "NOT met",
    "planned": "not checked",
}


def ladder_file(case_dir: Path, run: str) -> Path:
    """Return where `plymotion chart` writes the models of a run."""
    return case_dir / "plans" / f"{run}.ladder.json"


def with_ladder(case_dir: Path, story: Story) -> Story:
    """Return the run with the models of `plymotion chart`, if they are those of its plan.

    Otherwise, and if the file is damaged, the chart has the models that planning has tried.
    """
    found = story.summary.get("fidelity")
    if found is None:
        return story
    try:
        ladder = json.loads(ladder_file(case_dir, story.name).read_text(encoding="utf-8"))
        if (ladder["plan"], ladder["asked"]) != (found["plan"], found["asked"]):
            return story
    except (OSError, ValueError, KeyError, TypeError):
        return story
    return replace(story, summary={**story.summary, "fidelity": {**found, "ladder": ladder}})


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
        "is delivered, its own error is less, and at most about that of the model; no run tells "
        "how much less. Errors are relative to the scale.</p>",
        _overview(planned),
        *(_details(story) for story in planned),
    )


def _overview(stories: list[Story]) -> str:
    head = ["run", "asked", "metric", "request", "signal", "scale", "estimated error of the model"]
    head += ["delivered run", "its error at most", "CPU [s]"]
    rows: list[Row] = []
    for story in stories:
        found = story.summary["fidelity"]
        for name, scale in found["scale"].items():
            estimate = (found["estimate"] or {}).get(name)
            delivered = found.get("delivered", {"run": "", "error_at_most": {}})
            most = delivered["error_at_most"].get(name)
            rows.append(
                [
                    name_of(story),
                    figures(found["asked"]),
                    escape(found["metric"]),
                    CHECKED.get(found["verdict"], escape(found["verdict"])),
                    escape(name),
                    figures(scale),
                    "none" if estimate is None else Cell(f"{estimate:.1e}", estimate),
                    escape(delivered["run"]),
                    "not estimated" if most is None else Cell(f"{most:.1e}", most),
                    figures(sum(found["cpu"].values())),
                ]
            )
    return table("Accuracy asked and estimated", head, rows)


def _details(story: Story) -> str:
    found = story.summary["fidelity"]
    parts = [f"<h3>{name_of(story)}</h3>", _words(found), _plan(found["plan"])]
    if found["shares"]:
        parts.append(_shares(found["shares"]))
    if found.get("ladder"):
        parts.append(chart(found["ladder"], story.title))
        drawn = found["ladder"]["check"]["error"] > 0.0
        richest = (
            "square: the check. Errors are differences from the richest model."
            if drawn
            else "errors are differences from the check, which is not drawn itself. "
            "<code>plymotion chart</code> compares it with a richer model."
        )
        parts.append(
            "<p>Circles: models that were tried; line: their front; diamond: the chosen model, "
            f"with its estimate as a bar; {richest}</p>"
        )
    items = "".join(f"<li>{escape(text)}</li>" for text in found["not_checked"])
    parts.append(f"<p>Not checked:</p><ul>{items}</ul>")
    return "\n".join(parts)


def _words(found: Mapping[str, Any]) -> str:
    lines = []
    if found["reason"]:
        lines.append(f"{CHECKED.get(found['verdict'], '')}: {found['reason']}.")
    if found["base"] != "rigid":
        lines.append(f"The bodies cannot all be rigid: {found['base']}.")
    if found["horizon"] is not None:
        lines.append(
            f"From t = {found['horizon']:.4g} s on, a change of the masses by 1e-6 has grown to "
            "the accuracy: the estimate holds for this very run only."
        )
    lines += [f"{text[0].upper()}{text[1:]}." for text in found.get("theories", [])]
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


def _shares(shares: list[dict[str, Any]]) -> str:
    rows: list[Row] = [
        [escape(s["kind"]), escape(s["body"] or "all"), Cell(f"{s['value']:.1e}", s["value"])]
        for s in shares
    ]
    head = ["kind", "body", "share of the error"]
    return table("Shares of the error of the last plan that was too coarse", head, rows)
