"""Panel of a cylinder about the x axis, region "panel", normal outwards.

x from 0 to length, angles counted from the z axis towards y. Physical curves near (x = 0), far,
first (the first angle), second; physical points near-first, near-second, far-first, far-second.
The defaults are a quarter of the Scordelis-Lo roof; near is its middle, far its diaphragm.
"""

import runpy
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

grid = runpy.run_path(str(Path(__file__).with_name("grid.py")))

DEFAULTS: dict[str, float] = {
    "radius": 25.0,  # [m]
    "length": 25.0,  # [m]
    "first_deg": 0.0,
    "second_deg": 40.0,
    "n_length": 16,  # cells along x
    "n_around": 16,
    "diagonals": 1,  # 0 one way, 1 alternating, 2 the other way
    "distortion": 0.0,  # largest shift of an inner node over the length of a cell
    "seed": 1,  # of these random shifts
}


def build(gmsh: Any, parameters: Mapping[str, Any]) -> None:
    """Fill gmsh's current model; parameters: see DEFAULTS. Raises ValueError."""
    table = grid["checked"](DEFAULTS, parameters)
    first, second = np.radians([float(table["first_deg"]), float(table["second_deg"])])
    radius, length = float(table["radius"]), float(table["length"])

    def place(u: Any, v: Any) -> tuple[Any, Any, Any]:
        angle = first + v * (second - first)
        return u * length, radius * np.sin(angle), radius * np.cos(angle)

    n = int(table["n_length"]), int(table["n_around"])
    at = grid["mapped"]("panel", place, n, table)
    p = at.places
    curves = {"near": [p[0]], "far": [p[-1]], "first": [p[:, 0]], "second": [p[:, -1]]}
    points = {
        "near-first": p[0, 0],
        "near-second": p[0, -1],
        "far-first": p[-1, 0],
        "far-second": p[-1, -1],
    }
    grid["write"](gmsh, [at], curves, points)


if __name__ == "__main__":
    grid["show"](build, sys.argv[1:])
