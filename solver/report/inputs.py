"""The section of report.html on inputs: what differs between runs, versions, digests, command."""

import json
from html import escape
from typing import Any

from .elements import Row, section, table
from .story import Story

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
        found = story.summary.get("provenance", {})
        versions = ", ".join(f"{name} {v}" for name, v in found.get("versions", {}).items())
        rows.append(
            [
                escape(story.title),
                f"<code>{escape(str(story.summary.get('inputs_sha256', '-')))}</code>",
                f"<code>{escape(story.sha256)}</code>",
                escape(versions or "-"),
                f"<code>{escape(str(found.get('command', '-')))}</code>",
            ]
        )
    head = ["run", "SHA-256 of the inputs", "SHA-256 of result.vtkhdf", "versions", "command"]
    return f"<h3>Provenance</h3>{table('Where the results come from', head, rows)}"


def _flat(inputs: Any, prefix: str = "") -> dict[str, Any]:
    """Return a nested table by dotted keys; keys without a value are left out."""
    if not isinstance(inputs, dict):
        return {} if inputs is None else {prefix: inputs}
    found: dict[str, Any] = {}
    for key, value in inputs.items():
        found |= _flat(value, f"{prefix}.{key}" if prefix else str(key))
    return found


def _value(value: Any) -> str:
    if value is None:
        return "-"
    text = json.dumps(value) if isinstance(value, list | bool) else str(value)
    return escape(text if len(text) <= LONG else text[: LONG - 1] + "…")
