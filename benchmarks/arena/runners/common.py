"""What runners share: the protocol of a runner that is a Python script. Imports NumPy only.

A runner is one file with

NAME : of the code
ENVIRONMENT : {"pip": [requirements]}, with "alone": those installed without what they ask for;
    {"program": name, "how": the command that installs it}
FIXED : optional, methods that take fixed steps, for the map of stability
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
FORCES = ("spring", "springs", "motors", "sampled", "rolling")


def main(solve: Callable[[Sheet, Sheet], Any]) -> None:
    """Run `solve(sheet, setting)`, a generator or function whose result is the values.

    `solve` returns (values, CPU seconds of the solution alone).
    """
    folder = Path(sys.argv[1])
    job = json.loads((folder / "in.json").read_text(encoding="utf-8"))
    sheet = json.loads(Path(job["sheet"]).read_text(encoding="utf-8"))
    if "cells" in job:  # of the map of stability
        out = {m: [reach(solve, sheet, m, *cell) for cell in job["cells"]] for m in job["methods"]}
    else:
        values, seconds = solve(sheet, job["setting"])
        out = {"values": values, "solution_s": seconds}
    (folder / "out.json").write_text(json.dumps(out), encoding="utf-8")


def reach(solve: Callable[[Sheet, Sheet], Any], sheet: Sheet, m: str, k: float, h: float) -> Any:
    """Largest |x| of the probe in 200 steps h with a spring k; None: not finite, or stopped."""
    springs = [sheet["data"]["springs"][0] | {"stiffness": k}]
    own = sheet | {"every": h, "t_end": 200 * h, "times": [h * (i + 1) for i in range(200)]}
    try:
        rows, _ = solve(
            own | {"data": {"springs": springs}}, {"method": m, "steps": 200, "fixed": h}
        )
    except Exception:  # whatever a code raises where it does not converge
        return None
    largest = max(abs(row[0]) for row in rows)
    return largest if largest < 1e300 else None


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
    sheet: Sheet, joints: set[str], data: tuple[str, ...] = (), modal: bool = False
) -> str:
    """Why a multibody code with these joints and entries of `data` cannot do a scene.

    Forces are given as `data` of the scene: `springs` and `motors` of joints, `sampled` control,
    a `spring` with friction.
    """
    if sheet["kind"] != "mechanism":
        return "a multibody code"
    if "beam" in sheet:
        return "no flexible bodies"
    if not modal and any("modal" in body for body in sheet["bodies"]):
        return "no flexible bodies with modes"
    if other := kinds(sheet) - joints:
        return f"no joint {', '.join(sorted(other))}"
    found = {f["kind"] for f in (sheet["forces"] or {}).values()}
    named = set(FORCES) & set(sheet.get("data", {}))
    if found and not named:
        return f"no force {', '.join(sorted(found))} in this runner"
    if other := named - set(data):
        return f"no {', '.join(sorted(other))} in this runner"
    if sheet["couplings"]:
        return "no couplings in this runner"
    return ""


def held(sheet: Sheet) -> int:
    """Outputs between two instants at which a sampled controller acts, at least 1."""
    period = sheet.get("data", {}).get("sampled", {}).get("period", sheet["every"])
    return max(1, round(period / sheet["every"]))
