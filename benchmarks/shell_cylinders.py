r"""Load factors of cross-ply cylinders under axial compression: ours, Ritz series, CalculiX (S8R).

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/shell_cylinders.py

A quarter of a cylinder, R = L = 1 m, R/h = 100, compressed by a line load at the far end. Both
codes hold the near end along x, both ends around and outwards, for prestress and buckling; the
series have an even prestress. The load is a tenth of the critical one: *BUCKLE misses factors below
1. CalculiX is left out where `ccx` is not installed.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from peers import cylinder_peer
from samples.cylinder_samples import LAMINA, cylinder, write_cylinder

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

R = L = 1.0
H = 0.01
UNIT = 1e10  # of the moduli [Pa]
LAYUPS = ([0.0, 90.0, 90.0, 0.0], [90.0, 0.0, 0.0, 90.0])
OURS, S8R = ((24, 36), (48, 72)), ((12, 18), (18, 27))


def ours(angles: list[float], n: tuple[int, int], load: float) -> tuple[float, float]:
    """Our factor for a line load [N/m], and that of the series."""
    with tempfile.TemporaryDirectory() as folder:
        file = write_cylinder(Path(folder) / "c.msh", R, L, n, 90.0)
        spec = cylinder(file, angles, H, "compression")
        moduli = {k: UNIT * v for k, v in LAMINA.items() if k[0] in "EG"}
        spec["materials"] = {"ply": {**LAMINA, **moduli}}
        spec["supports"] = {
            "near": {"at": "near", "fixed": ["ux", "uy", "uz"]},
            "far": {"at": "far", "fixed": ["uy", "uz"]},
            "first": spec["supports"]["first"],
            "second": spec["supports"]["second"],
        }
        spec["loads"]["compression"]["far"]["force_per_length"] = [-load, 0.0, 0.0]
        found = analyse(spec).buckling
        assert found is not None
        wall = ShellProblem(spec).regions[0].stiffness
    N = (-load, 0.0, 0.0)
    exact = cylinder_peer.smallest(wall.ABD, wall.Ds, R, L, range(2, 26, 2), range(1, 9), N)[0]
    return float(found.factors[0]), exact


def constants() -> str:
    """Engineering constants with the fibre along the first axis."""
    m: dict[str, Any] = {
        k: UNIT * v if k[0] in "EG" else v for k, v in LAMINA.items() if k != "kind"
    }
    keys = ("E1", "E2", "E3", "nu12", "nu13", "nu23", "G12", "G13")
    return ", ".join(f"{m[key]:.10g}" for key in keys) + f"\n{m['G23']:.10g}"


def peer(angles: list[float], n: tuple[int, int], load: float) -> float:
    """Factor of *BUCKLE."""
    rows, columns = 2 * n[0] + 1, 2 * n[1] + 1
    number = 1 + np.arange(rows * columns).reshape(rows, columns)
    angle = 0.5 * np.pi * np.arange(columns) / (columns - 1)
    lines = ["*NODE, NSET=ALL"]
    for i in range(rows):
        lines += [
            f"{number[i, j]}, {L * i / (rows - 1):.12g}, {R * np.sin(t):.12g}, {R * np.cos(t):.12g}"
            for j, t in enumerate(angle)
        ]
    k = 0
    for j in range(0, columns - 2, 2):  # axes of each column of elements
        lines.append(f"*ELEMENT, TYPE=S8R, ELSET=W{j}")
        for i in range(0, rows - 2, 2):
            a, k = number[i : i + 3, j : j + 3], k + 1
            ring = [a[0, 0], a[2, 0], a[2, 2], a[0, 2], a[1, 0], a[2, 1], a[1, 2], a[0, 1]]
            lines.append(f"{k}, " + ", ".join(map(str, ring)))
    lines += ["*MATERIAL, NAME=PLY", "*ELASTIC, TYPE=ENGINEERING CONSTANTS", constants()]
    for j in range(0, columns - 2, 2):
        t = angle[j + 1]
        along, around = (1.0, 0.0, 0.0), (0.0, float(np.cos(t)), float(-np.sin(t)))
        for name, axes in (("0", (*along, *around)), ("90", (*around, *(-x for x in along)))):
            lines.append(f"*ORIENTATION, NAME=O{j}A{name}, SYSTEM=RECTANGULAR")
            lines.append(", ".join(f"{v:.12g}" for v in axes))
        lines.append(f"*SHELL SECTION, COMPOSITE, ELSET=W{j}")
        lines += [f"{H / len(angles):.9g}, , PLY, O{j}A{ply:.0f}" for ply in angles]
    lines.append("*BOUNDARY")
    lines += [f"{i}, 1, 3" for i in number[0]] + [f"{i}, 2, 3" for i in number[-1]]
    for column, held in ((0, (2, 4, 6)), (-1, (3, 4, 5))):
        lines += [f"{i}, {d}, {d}" for i in number[:, column] for d in held]
    lines += ["*STEP", "*BUCKLE", "2, 1e-6", "*CLOAD"]
    side = load * R * 0.5 * np.pi / n[1]
    for j in range(columns):
        share = 4 if j % 2 else (1 if j in (0, columns - 1) else 2)
        lines.append(f"{number[-1, j]}, 1, {-side * share / 6.0:.12g}")
    lines.append("*END STEP")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "model.inp").write_text("\n".join(lines) + "\n")
        subprocess.run(["ccx", "model"], cwd=folder, capture_output=True, check=False)
        text = Path(folder, "model.dat").read_text().splitlines()
    found = [line.split() for line in text if re.match(r"^\s+\d+\s+-?\d\.\d+E", line)]
    return float(found[0][1])


def main() -> None:
    for angles in LAYUPS:
        print(angles)
        load = 1.0
        load = 0.1 * ours(angles, OURS[0], load)[0]
        for n in OURS:
            found, exact = ours(angles, n, load)
            print(
                f"  quadrilaterals {n!s:9s} {found:.4f}, series {exact:.4f} ({found / exact:.4f})"
            )
        if shutil.which("ccx"):
            for n in S8R:
                found = peer(angles, n, load)
                print(f"  CalculiX S8R   {n!s:9s} {found:.4f} ({found / exact:.4f})", flush=True)


if __name__ == "__main__":
    main()
