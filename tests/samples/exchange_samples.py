"""A brick as another code would hand it over: Matrix Market, CSV and an import file."""

from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from samples.brick_model import Brick, brick

from plymotion.preprocess.exchange.__main__ import main

SIZE, COUNT, DENSITY = (0.5, 0.04, 0.01), (20, 3, 2), 2700.0
TOTAL = DENSITY * 0.5 * 0.04 * 0.01
ROOT = [[-1e-6, -1.0, -1.0], [1e-6, 1.0, 1.0]]
TIP = [[0.5 - 1e-6, -1.0, -1.0], [0.5 + 1e-6, 1.0, 1.0]]
DIRECTIONS = ["x", "y", "z", "rx", "ry", "rz"]


def bar() -> Brick:
    """The arm's outer form, in aluminium."""
    return brick(SIZE, COUNT, density=DENSITY)


def request(**changes: Any) -> dict[str, Any]:
    """Arguments of `from_matrices` besides the matrices."""
    return {
        "body": "arm",
        "interfaces": {
            "root": {"box": ROOT, "link": "rigid"},
            "tip": {"box": TIP, "link": "rigid"},
        },
        "reference": {"kind": "clamped", "at": "root"},
        "modes": [
            {"kind": "lowest", "count": 6},
            {"kind": "attachment", "at": "tip", "directions": DIRECTIONS},
        ],
        **changes,
    }


IMPORT_FILE = """\
format = 1
body = "arm"
from = "matrices"
units = {{ length = "{length}", mass = "{mass}", time = "s" }}
total_mass = {total}
reference = {{ kind = "clamped", at = "root" }}
damping_ratio = 0.01
modes = [
    {{ kind = "lowest", count = 6 }},
    {{ kind = "attachment", at = "tip", directions = ["x", "y", "z", "rx", "ry", "rz"] }},
]

[files]
stiffness = "K.mtx"
mass = "M.mtx"
nodes = "nodes.csv"
dofs = "dofs.csv"
cells = "cells.csv"

[interfaces]
root = {{ box = [[{root}, -1e3, -1e3], [{root_end}, 1e3, 1e3]], link = "rigid" }}
tip = {{ box = [[{tip}, -1e3, -1e3], [1e3, 1e3, 1e3]], link = "rigid" }}
"""


def write_matrices(
    folder: Path, body: Brick, length: str = "m", scale: float = 1.0, unit_mass: float = 1.0
) -> Path:
    """Write the files of a body; `scale` units of length are 1 m, a unit of mass `unit_mass` kg."""
    folder.mkdir(parents=True, exist_ok=True)
    K = body.K / unit_mass  # force per length: mass / s2
    scipy.io.mmwrite(folder / "K.mtx", K, symmetry="symmetric", precision=17)
    scipy.io.mmwrite(folder / "M.mtx", body.M / unit_mass, symmetry="symmetric", precision=17)
    lines = ["node,x,y,z"]
    for i, point in enumerate(body.nodes * scale, 1):
        lines.append(",".join([str(i), *(f"{value:.17g}" for value in point)]))
    (folder / "nodes.csv").write_text("\n".join(lines) + "\n")
    words = [f"{node},{'xyz'[direction - 1]}" for node, direction in body.dofs]
    (folder / "dofs.csv").write_text("\n".join(["node,direction", *words]) + "\n")
    cells = [",".join(["12", *map(str, cell + 1)]) for cell in body.cells]
    (folder / "cells.csv").write_text("\n".join(["type,nodes", *cells]) + "\n")
    mass = {1.0: "kg", 1e3: "t"}[unit_mass]
    end = float(np.max(body.nodes[:, 0])) * scale
    file = folder / "arm.toml"
    file.write_text(
        IMPORT_FILE.format(
            length=length,
            mass=mass,
            total=TOTAL,
            root=-1e-6 * scale,
            root_end=1e-6 * scale,
            tip=end - 1e-6 * scale,
        )
    )
    return file


def exported(file: Path, target: str, out: Path) -> Path:
    """Export a package in the format of another code; its file."""
    assert main(["export", str(file), "--to", target, "-o", str(out)]) == 0
    return out
