"""MYSTRAN: shells of CQUAD4 (MIN4T) on the grids of our plates and cylinders, with PCOMP.

K6ROT = 100 is the usual stiffness about normals, which facets of curved shells need.
Writing the deck is not timed, reading of it is.
"""

import re
from pathlib import Path
from typing import Any

import description
import numpy as np
from common import Sheet
from in_calculix import DOFS, grid, no_grid, shares, weight

NAME = "MYSTRAN"
BINARY = "build/exchange-programs/mystran/mystran/_data/bin/mystran"
ENVIRONMENT = {"program": BINARY, "how": "make exchange-programs", "version": "18.0.0.1"}
INSIDE = True  # writes into the current folder
HELD = {"symmetry-x": "156", "symmetry-y": "246", "symmetry-z": "345", "all": "123456"}


def cannot(sheet: Sheet) -> str:
    """Shells on grids."""
    if sheet["kind"] != "shell":
        return "a finite-element code: shells here"
    table = description.read_toml(sheet)
    if "buckling" in table or "sine" in str(table.get("loads")):
        return "no buckling and no sine loads in this runner"
    return no_grid(table)


def settings(sheet: Sheet) -> list[Sheet]:
    """Cells along each side."""
    return [{"method": "CQUAD4", "cells": n} for n in (8, 16, 32, 64)]


def prepare(sheet: Sheet, setting: Sheet, folder: Path, python: str) -> list[str]:
    """Write the deck."""
    (folder / "model.dat").write_text(deck(description.read_toml(sheet), setting["cells"]))
    return [python, "model.dat"]


def large(name: str, *fields: Any) -> list[str]:
    """A card of large fields, 16 columns each."""
    words = [f"{f:16.9E}" if isinstance(f, float) else f"{f:>16}" for f in fields]
    lines = [f"{name + '*':8}" + "".join(words[:4]), "*       " + "".join(words[4:])]
    return lines[: 2 if words[4:] else 1]


def deck(table: Sheet, n: int) -> str:
    """Bulk data of a description."""
    (places, number), sets = grid(table["mesh"], n // 2)
    modes = "frequencies" in table
    lines = ["ID ARENA,SHELL", f"SOL {3 if modes else 1}", "CEND", "SPC = 1"]
    lines += ["METHOD = 1"] if modes else ["LOAD = 1", "DISP = ALL"]
    lines += ["BEGIN BULK", "PARAM,SOLLIB,BANDED", "PARAM,K6ROT,100.", "EIGRL,1,,,3"]
    for k, place in enumerate(places.reshape(-1, 3)):
        lines += large("GRID", k + 1, "", *map(float, place))
    rings = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    for k, ring in enumerate(np.stack(rings, axis=2).reshape(-1, 4)):
        lines.append(f"CQUAD4,{k + 1},1," + ",".join(map(str, ring)))
    (region,) = table["regions"].values()
    laminate = table.get("laminates", {}).get(region.get("laminate"), {})
    m = table["materials"][laminate.get("material", region.get("material"))]
    if laminate:
        names = ("E1", "E2", "nu12", "G12", "G13", "G23", "rho")
        lines += large("MAT8", 1, *(float(m[name]) for name in names))
        angles = laminate["angles_deg"] * laminate.get("repeat", 1)
        angles += angles[::-1] * laminate.get("symmetric", False)
        lines.append("PCOMP,1")
        plies = [f"1,{laminate['ply_thickness']},{float(a)},YES" for a in angles]
        lines += ["," + ",".join(plies[k : k + 2]) for k in range(0, len(plies), 2)]
    else:
        lines += large("MAT1", 1, float(m["E"]), "", float(m["nu"]), float(m["rho"]))
        lines.append(f"PSHELL,1,1,{region['thickness']},1,,1")
    for support in table["supports"].values():
        fixed = support["fixed"]
        numbers = "" if isinstance(fixed, str) else "".join(str(DOFS.index(d) + 1) for d in fixed)
        held = numbers or HELD[fixed]
        lines += [f"SPC1,1,{held},{node}" for node in sets[support["at"]]]
    for case in table.get("loads", {}).values():
        for load in [case] if "at" in case else case.values():
            if "force_per_area" in load:
                lines += large("GRAV", 1, 0, *weight(load, region, m))
            else:
                nodes, f = sets[load["at"]], list(map(float, load["force"]))
                for node, share in zip(nodes, shares(len(nodes), 2.0), strict=True):
                    lines += large("FORCE", 1, node, 0, float(share), *f)
    return "\n".join([*lines, "ENDDATA", ""])


def read(sheet: Sheet, setting: Sheet, folder: Path) -> Sheet:
    """The first frequency, or the displacement of the probe that the scene asks for."""
    (name, path), *_ = sheet["values"].items()
    text = (folder / "model.F06").read_text(errors="replace")
    if path[0] == "frequencies_hz":
        row = re.findall(r"^\s+1\s+1\s+\S+\s+\S+\s+(\S+)", text, re.MULTILINE)[0]
        return {"values": {name: float(row)}}
    table = description.read_toml(sheet)
    _, sets = grid(table["mesh"], setting["cells"] // 2)
    node = sets[table["probes"][path[3]]["at"]][0]
    row = re.findall(rf"^\s+{node}\s+0((?:\s+-?\d\S*){{6}})\s*$", text, re.MULTILINE)[0].split()
    return {"values": {name: abs(float(row[DOFS.index(path[-1])]))}}
