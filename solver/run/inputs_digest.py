"""What a result depends on: the run file, its packages, the sources of the solver."""

import hashlib
import json
from pathlib import Path
from typing import Any

from ..inputs.case.run_table import package_entries
from ..inputs.case.sources import solver_sha256
from ..package.common.disk_file import has_right_seal
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


def up_to_date(file: Path, out: Path) -> dict[str, Any] | None:
    """Return the summary of a result that was not interrupted and has the inputs of a run file."""
    try:
        summary = read_summary(out / "summary.json")
    except ResultError:
        return None
    there = has_right_seal(out / "result.vtkhdf") and summary.get("status") != "interrupted"
    known = summary.get("inputs_sha256")
    return summary if there and known and known == inputs_sha256(file) else None
