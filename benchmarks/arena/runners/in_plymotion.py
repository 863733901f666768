"""Ours: `plymotion run`, `section` and `shell` as a user calls them, every integrator."""

import json
from pathlib import Path
from typing import Any

import description
from common import Sheet

NAME = "Plymotion"
ENVIRONMENT: dict[str, Any] = {"own": True}
METHODS = {
    "radau": {"integrator": "radau"},
    "rk8": {"integrator": "rk8"},
    "rk5": {"integrator": "rk5"},
    "generalized-alpha": {"integrator": "generalized-alpha", "constraints": "ggl"},
    "gear": {"integrator": "gear", "max_order": 2},
}
RTOLS = {
    "radau": [1e-3, 3e-4, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9],
    "rk8": [1e-4, 1e-6, 1e-8, 1e-10, 1e-12],
    "rk5": [1e-6],
    "generalized-alpha": [1e-3, 1e-5],
    "gear": [1e-3],
}


def cannot(sheet: Sheet) -> str:
    """Nothing of the scenes of today, except what a scene says."""
    return str(sheet.get("ours", {}).get("cannot", ""))


def settings(sheet: Sheet) -> list[Sheet]:
    """Each integrator, from coarse to fine; sections and shells by mesh."""
    if sheet["kind"] == "section":
        return [{"method": "section", "density": d} for d in (0.5, 1.0, 2.0)]
    if sheet["kind"] == "shell":
        return [{"method": "shell", "cells": n} for n in sheet["ours"]["cells"]]
    if sheet["kind"] == "modes":
        return [{"method": "modes", "modes": n} for n in sheet["ours"]["modes"]]
    if "beam" in sheet:
        pairs = sheet["ours"]["rtols"]
        return [
            {"method": "radau", "segments": n, "rtol": r}
            for n, r in zip(sheet["ours"]["segments"], pairs, strict=True)
        ]
    wanted = sheet.get("ours", {}).get("methods", list(METHODS))
    if "ladder" in sheet.get("ours", {}):
        return [{"method": m, **entry} for m in wanted for entry in sheet["ours"]["ladder"]]
    return [{"method": m, "rtol": r} for m in wanted for r in RTOLS[m]]


def prepare(sheet: Sheet, setting: Sheet, folder: Path, python: str) -> list[str]:
    """Write the run file or description and return the command."""
    start = [python, "-m", "plymotion"]
    if sheet["kind"] == "modes":
        file = sheet["run_files"][str(setting["modes"])]
        out = ["--json", "--shapes", "0", "--out", str(folder / "out")]
        return [*start, "modes", file, "--at", sheet["at"], *out]
    if sheet["kind"] != "mechanism":
        return description.command(sheet, setting, folder, python)
    original = Path(
        sheet["run_files"][str(setting["segments"])] if "beam" in sheet else sheet["run_file"]
    )
    table = json.loads(original.read_text(encoding="utf-8"))
    solver = METHODS[setting["method"]] | {"rtol": setting["rtol"]}
    for name, keys in setting.get("forces", {}).items():
        table["mechanism"]["forces"][name] |= keys
    file = changed(original, table, solver, folder)
    return [*start, "run", str(file), "--out", str(folder / "out"), "--quiet"]


def changed(original: Path, table: Sheet, solver: Sheet, folder: Path) -> Path:
    """The run file with another [solver], checked and sealed."""
    from mechanism_sheet import FOLDER, write_run

    packages = {
        body: (original.parent.parent / entry["file"]).resolve()
        for body, entry in table["packages"].items()
    }
    mechanism = table["mechanism"]
    return write_run(
        f"{original.stem}/{folder.name}",
        mechanism | {"solver": mechanism["solver"] | solver},
        packages,
        FOLDER,
    )


def read(sheet: Sheet, setting: Sheet, folder: Path) -> Sheet:
    """Positions of the probe, or the numbers of the description, and phases of the run."""
    if sheet["kind"] == "modes":
        told = (folder / "told.txt").read_text(encoding="utf-8")
        modes = json.loads(told[told.index("{") : told.rindex("}") + 1])["modes"]
        rates = [m["angular_frequency"] for m in modes if m["angular_frequency"] > 0.0]
        return {"values": {name: rates[k] for name, k in sheet["values"].items()}}
    if sheet["kind"] != "mechanism":
        return description.numbers(sheet, folder)
    import numpy as np

    from plymotion.solver.results.file import read_result

    summary = json.loads((folder / "out/summary.json").read_text(encoding="utf-8"))
    if summary["status"] != "finished":
        raise RuntimeError(summary.get("message", summary["status"]))
    result = read_result(folder / "out/result.vtkhdf")
    signals = {s.name: s.values for s in result.signals}
    paths = np.stack([np.ravel(signals[axis]) for axis in "xyz"], axis=1)[1:]
    seconds = summary["cost"]["seconds"]
    return {
        "values": paths.tolist(),
        "solution_s": seconds["integrate"] + seconds["monitors"],
        "phases": seconds,
        "steps": summary["cost"]["steps"],
    }
