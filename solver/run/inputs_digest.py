"""What a result depends on: the run file, its packages, the sources of the solver."""

import hashlib
import json
import tomllib
from pathlib import Path
from typing import Any

from ..inputs.case.record import package_entries, solver_sha256
from ..package.common.files import has_right_seal
from ..results import ResultError, read_summary


def inputs_sha256(file: Path) -> str:
    """Return the digest of all that the result of a run depends on; "" if a part is missing."""
    try:
        content = file.read_bytes()
        digest = hashlib.sha256(solver_sha256().encode() + content)
        table = json.loads(content)
        for entry in package_entries(table):
            digest.update((file.parent.parent / entry["file"]).read_bytes())
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return ""
    return digest.hexdigest()


def still(file: Path, digest: str) -> str:
    """Return the digest of inputs that were read since it was computed; "" if they have changed.

    Then nobody knows what was read, and the result is up to date with nothing.
    """
    return digest if inputs_sha256(file) == digest else ""


def plan_file(file: Path) -> Path:
    """Return where the plan of a run file with `[fidelity]` is."""
    return file.parent.parent / "plans" / f"{file.stem}.toml"


def plan_sha256(plan: Path) -> str:
    """Return the digest of what a plan says, without remarks and inputs; "" if it is no plan."""
    try:
        return text_sha256(plan.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return ""


def text_sha256(plan: str) -> str:
    """Return the digest of the text of a plan; see `plan_sha256`."""
    table = tomllib.loads(plan)
    table.pop("inputs_sha256", None)
    return hashlib.sha256(json.dumps(table, sort_keys=True, default=str).encode()).hexdigest()


def up_to_date(file: Path, out: Path) -> dict[str, Any] | None:
    """Return the summary of a result that was not interrupted and has the inputs of a run file.

    The plan of a run with `[fidelity]`, which may be edited, is one of them.
    """
    try:
        summary = read_summary(out / "summary.json")
    except ResultError:
        return None
    there = has_right_seal(out / "result.vtkhdf") and summary.get("status") != "interrupted"
    known = summary.get("inputs_sha256")
    if not (there and known and known == inputs_sha256(file)):
        return None
    planned = summary.get("fidelity")
    if planned and planned.get("plan_sha256") != plan_sha256(plan_file(file)):
        return None
    return summary
