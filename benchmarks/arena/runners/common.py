"""What runners share: the protocol of a runner that is a Python script. Imports NumPy only.

A runner is one file with

NAME : of the code
ENVIRONMENT : {"pip": [requirements]}, {"program": name, "apt": package} or {"own": True}
cannot(sheet) : why it cannot do a scene, "" if it can
settings(sheet) : a ladder of settings, each a dict with "method"
prepare(sheet, setting, folder, python) : writes what it needs, returns the command to be timed
read(sheet, setting, folder) : {"values": ..., "solution_s": CPU seconds of the solution}

Without `prepare` and `read` the file itself is the script that is timed: it calls `main(solve)`.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

Sheet = dict[str, Any]


def main(solve: Callable[[Sheet, Sheet], Any]) -> None:
    """Run `solve(sheet, setting)`, a generator or function whose result is the values.

    `solve` returns (values, CPU seconds of the solution alone).
    """
    folder = Path(sys.argv[1])
    job = json.loads((folder / "in.json").read_text(encoding="utf-8"))
    sheet = json.loads(Path(job["sheet"]).read_text(encoding="utf-8"))
    values, seconds = solve(sheet, job["setting"])
    out = {"values": values, "solution_s": seconds}
    (folder / "out.json").write_text(json.dumps(out), encoding="utf-8")


class Timed:
    """CPU seconds of a block."""

    def __enter__(self) -> "Timed":
        self.begin, self.seconds = time.process_time(), 0.0
        return self

    def __exit__(self, *_: object) -> None:
        self.seconds = time.process_time() - self.begin


def kinds(sheet: Sheet) -> set[str]:
    """Kinds of joints."""
    return {joint["kind"] for joint in sheet["joints"]}


def not_mechanical(
    sheet: Sheet,
    joints: set[str],
    forces: set[str] = frozenset(),
    modal: bool = False,  # type: ignore[assignment]
) -> str:
    """Why a multibody code with these joints and forces cannot do a scene."""
    if sheet["kind"] != "mechanism":
        return "a multibody code"
    if not modal and any("modal" in body for body in sheet["bodies"]):
        return "no flexible bodies with modes"
    if other := kinds(sheet) - joints:
        return f"no joint {', '.join(sorted(other))}"
    found = {f["kind"] for f in (sheet["forces"] or {}).values()}
    if other := found - forces:
        return f"no force {', '.join(sorted(other))} in this runner"
    if sheet["couplings"]:
        return "no couplings in this runner"
    return ""
