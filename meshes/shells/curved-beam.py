"""Quarter of a flat ring in z = 0, from the y axis (root) to the x axis (tip), region "beam".

The curved cantilever of MacNeal and Harder: root at x = 0, tip at y = 0. Physical curves root, tip,
inner, outer.
"""

import runpy
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

grid = runpy.run_path(str(Path(__file__).with_name("grid.py")))

DEFAULTS: dict[str, float] = {
    "inner_radius": 4.12,  # [m]
    "outer_radius": 4.32,  # [m]
    "n_length": 12,
    "n_width": 1,
    "diagonals": 1,  # 0 one way, 1 alternating, 2 the other way
    "distortion": 0.0,  # largest shift of an inner node over the length of a cell
    "seed": 1,  # of these random shifts
}


def build(gmsh: Any, parameters: Mapping[str, Any]) -> None:
    """Fill gmsh's current model; parameters: see DEFAULTS. Raises ValueError."""
    table = grid["checked"](DEFAULTS, parameters)
    inner, outer = float(table["inner_radius"]), float(table["outer_radius"])

    def place(u: Any, v: Any) -> tuple[Any, Any, Any]:
        radius = inner + v * (outer - inner)
        return radius * np.sin(0.5 * np.pi * u), radius * np.cos(0.5 * np.pi * u), 0.0 * u

    beam = grid["mapped"]("beam", place, (int(table["n_length"]), int(table["n_width"])), table)
    p = beam.places
    curves = {"root": [p[0]], "tip": [p[-1]], "inner": [p[:, 0]], "outer": [p[:, -1]]}
    grid["write"](gmsh, [beam], curves, {"tip-middle": p[-1, p.shape[1] // 2]})


if __name__ == "__main__":
    grid["show"](build, sys.argv[1:])
