"""Rectangular plate 0 <= x <= length, 0 <= y <= width in z = 0, region "plate".

Physical curves left (x = 0), right, bottom (y = 0), top; physical points corner-00, corner-10,
corner-11, corner-01 and, with even numbers of cells, centre and right-middle. Slanted cells, as in
MacNeal and Harder's straight beam: the inner lines across the plate are tilted, alternately or all
one way.
"""

import runpy
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

grid = runpy.run_path(str(Path(__file__).with_name("grid.py")))

DEFAULTS: dict[str, float] = {
    "length": 1.0,  # along x [m]
    "width": 1.0,  # along y [m]
    "n_length": 16,  # cells along x
    "n_width": 16,  # cells along y
    "slant": 0.0,  # shift of an inner line's upper end, and of its lower end the other way [m]
    "slant_alternates": 1,  # 1: trapezoids; 0: parallelograms
    "diagonals": 1,  # 0 one way, 1 alternating, 2 the other way
    "distortion": 0.0,  # largest shift of an inner node over the length of a cell
    "seed": 1,  # of these random shifts
}


def build(gmsh: Any, parameters: Mapping[str, Any]) -> None:
    """Fill gmsh's current model; parameters: see DEFAULTS. Raises ValueError."""
    table = grid["checked"](DEFAULTS, parameters)
    length, width = float(table["length"]), float(table["width"])
    n = int(table["n_length"]), int(table["n_width"])

    def place(u: Any, v: Any) -> tuple[Any, Any, Any]:
        line = np.arange(n[0] + 1)
        tilt = np.where((line == 0) | (line == n[0]), 0.0, float(table["slant"]))
        if table["slant_alternates"]:
            tilt = tilt * (-1.0) ** line
        return u * length + tilt[:, None] * (2.0 * v - 1.0), v * width, 0.0 * u

    plate = grid["mapped"]("plate", place, n, table, (n[0] // 2, n[1] // 2))
    at = plate.places
    curves = {
        "left": [at[0]],
        "right": [at[-1]],
        "bottom": [at[:, 0]],
        "top": [at[:, -1]],
    }
    points = {
        "centre": (0.5 * length, 0.5 * width, 0.0),
        "right-middle": (length, 0.5 * width, 0.0),
        "corner-00": at[0, 0],
        "corner-10": at[-1, 0],
        "corner-11": at[-1, -1],
        "corner-01": at[0, -1],
    }
    grid["write"](gmsh, [plate], curves, points)


if __name__ == "__main__":
    grid["show"](build, sys.argv[1:])
