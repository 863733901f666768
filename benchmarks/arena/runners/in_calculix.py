"""CalculiX: shells S8R (and S6) on the grids of our plates and cylinders; ccx alone is timed.

Its documented choice for laminates is S8R with *SHELL SECTION, COMPOSITE (one layer of solids for
each ply). Writing the deck is not timed, reading of ccx is.
"""

import re
import runpy
from pathlib import Path
from typing import Any

import description
import numpy as np
from common import Sheet

NAME = "CalculiX"
ENVIRONMENT: dict[str, Any] = {"program": "ccx", "how": "apt-get install calculix-ccx"}
INSIDE = True  # writes into the current folder
# Without rotations about z, nearly normal to these shells: held ones make its nodes rigid.
HELD = {"all": ["ux", "uy", "uz", "rx", "ry", "rz"]}
HELD |= {"symmetry-x": ["ux", "ry"], "symmetry-y": ["uy", "rx"], "symmetry-z": ["uz", "rx", "ry"]}
DOFS = ("ux", "uy", "uz", "rx", "ry", "rz")
NAMES = ("E1", "E2", "E3", "nu12", "nu13", "nu23", "G12", "G13", "G23")


def cannot(sheet: Sheet) -> str:
    """Shells on grids."""
    if sheet["kind"] != "shell":
        return "a finite-element code: shells here"
    table = description.read_toml(sheet)
    if "laminates" in table:
        return "laminates on SS-1 supports: this runner's deck is 4 % off, and not understood"
    return no_grid(table)


def no_grid(table: Sheet) -> str:
    """Why `grid` has no mesh of a description, or ""."""
    file = Path(table["mesh"]["file"]).name
    return "" if file in ("cylinder.py", "plate.py", "hook.py") else f"no mesh {file} here"


def settings(sheet: Sheet) -> list[Sheet]:
    """Cells along each side."""
    return [{"method": "S8R", "cells": n} for n in (4, 8, 16, 32)]


def prepare(sheet: Sheet, setting: Sheet, folder: Path, python: str) -> list[str]:
    """Write the deck."""
    (folder / "model.inp").write_text(deck(description.read_toml(sheet), setting["cells"]))
    return [python, "model"]


def grid(mesh: Sheet, n: int) -> tuple[Any, dict[str, list[int]]]:
    """Places (2 n + 1, 2 n + 1, 3) and nodes of edges and corners by our names."""
    p = mesh["parameters"]
    u, v = np.meshgrid(*[np.linspace(0.0, 1.0, 2 * n + 1)] * 2, indexing="ij")
    number = np.arange(u.size).reshape(u.shape) + 1
    edges = [number[0], number[-1], number[:, 0], number[:, -1]]
    if Path(mesh["file"]).name == "plate.py":
        names = ("left", "right", "bottom", "top")
        places = np.stack([u * p["length"], v * p["width"], 0.0 * u], axis=2)
    elif Path(mesh["file"]).name == "hook.py":
        names = ("root", "end", "low", "high")
        places = np.stack(runpy.run_path(mesh["file"])["place"](u, v), axis=2)
    else:
        names = ("near", "far", "first", "second")
        angle = np.radians(p.get("first_deg", 0.0)) * (1 - v) + np.radians(p["second_deg"]) * v
        places = np.stack(
            [u * p["length"], p["radius"] * np.sin(angle), p["radius"] * np.cos(angle)], axis=2
        )
    sets = {name: edge.tolist() for name, edge in zip(names, edges, strict=True)}
    for i, one in ((0, names[0]), (-1, names[1])):
        for j, two in ((0, names[2]), (-1, names[3])):
            sets[f"{one}-{two}"] = [int(number[i, j])]
    sets[f"{names[1]}-middle"] = [int(number[-1, n])]
    return (places, number), sets


def weight(load: Sheet, region: Sheet, material: Sheet) -> list[float]:
    """A force per area as the weight of a shell: acceleration and its direction."""
    f = np.array(load["force_per_area"])
    size = float(np.linalg.norm(f))
    return [size / region["thickness"] / material["rho"], *map(float, f / size)]


def shares(count: int, middle: float) -> Any:
    """Parts of a load on the nodes of an edge, or 1; nodes in the middle of cells: `middle`."""
    found = np.where(np.arange(count) % 2, middle, 2.0)
    found[[0, -1]] = 1.0
    return found / found.sum()


def deck(table: Sheet, n: int) -> str:
    """The input file of a description."""
    (places, number), sets = grid(table["mesh"], n)
    lines = ["*NODE, NSET=ALL"]
    flat = places.reshape(-1, 3)
    lines += [f"{k + 1}, {x:.15g}, {y:.15g}, {z:.15g}" for k, (x, y, z) in enumerate(flat)]
    lines.append("*ELEMENT, TYPE=S8R, ELSET=E")
    for i in range(0, 2 * n, 2):
        for j in range(0, 2 * n, 2):
            a = number[i : i + 3, j : j + 3]
            ring = [a[0, 0], a[2, 0], a[2, 2], a[0, 2], a[1, 0], a[2, 1], a[1, 2], a[0, 1]]
            lines.append(", ".join(map(str, [len(lines), *ring])))
    (region,) = table["regions"].values()
    lines += material(table, region)
    lines.append("*BOUNDARY")
    held = set()
    for support in table["supports"].values():
        fixed = support["fixed"]
        for dof in HELD[fixed] if isinstance(fixed, str) else fixed:
            held |= {(node, DOFS.index(dof) + 1) for node in sets[support["at"]]}
    lines += [f"{node}, {dof}, {dof}" for node, dof in sorted(held)]
    if "frequencies" in table:
        return "\n".join([*lines, "*STEP", "*FREQUENCY", "1", "*END STEP", ""])
    lines += ["*STEP", "*STATIC"]
    for case in table["loads"].values():
        for load in [case] if "at" in case else case.values():
            if "force_per_area" in load:
                g = weight(load, region, table["materials"][region["material"]])
                lines += ["*DLOAD", "E, GRAV, " + ", ".join(f"{v:.12g}" for v in g)]
            else:
                lines.append("*CLOAD")
                nodes = sets[load["at"]]
                lines += [
                    f"{node}, {d + 1}, {share * f:.12g}"
                    for node, share in zip(nodes, shares(len(nodes), 4.0), strict=True)
                    for d, f in enumerate(load["force"])
                    if f
                ]
    for probe in table["probes"].values():
        lines += ["*NSET, NSET=PROBE", str(sets[probe["at"]][0]), "*NODE PRINT, NSET=PROBE", "U"]
    return "\n".join([*lines, "*END STEP", ""])


def material(table: Sheet, region: Sheet) -> list[str]:
    """Material and section."""
    laminate = table.get("laminates", {}).get(region.get("laminate"), {})
    m = table["materials"][laminate.get("material", region.get("material"))]
    if m["kind"] == "isotropic":
        lines = ["*MATERIAL, NAME=M", "*ELASTIC", f"{m['E']:.12g}, {m['nu']:.12g}"]
    else:
        c = [f"{m[name]:.12g}" for name in NAMES]
        lines = ["*MATERIAL, NAME=M", "*ELASTIC, TYPE=ENGINEERING CONSTANTS"]
        lines += [", ".join(c[:8]) + ",", c[8]]
    lines += ["*DENSITY", f"{m['rho']:.12g}"]
    if not laminate:
        return [*lines, "*SHELL SECTION, ELSET=E, MATERIAL=M", f"{region['thickness']:.12g}"]
    angles = laminate["angles_deg"] * laminate.get("repeat", 1)
    for k, angle in enumerate(angles):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        lines += [f"*ORIENTATION, NAME=O{k}, SYSTEM=RECTANGULAR", f"{c}, {s}, 0, {-s}, {c}, 0"]
    lines.append("*SHELL SECTION, COMPOSITE, ELSET=E")
    return lines + [f"{laminate['ply_thickness']}, , M, O{k}" for k in range(len(angles))]


def read(sheet: Sheet, setting: Sheet, folder: Path) -> Sheet:
    """The first frequency, or the displacement of the probe that the scene asks for."""
    (name, path), *_ = sheet["values"].items()
    text = (folder / "model.dat").read_text()
    if path[0] == "frequencies_hz":
        rows = re.findall(r"^\s+1\s+\S+\s+\S+\s+(\S+)\s+\S+\s*$", text, re.MULTILINE)
        return {"values": {name: float(rows[0])}}
    row = text.split("displacements (vx,vy,vz)")[1].split("\n")[2].split()
    return {"values": {name: abs(float(row[1 + DOFS.index(path[-1])]))}}
