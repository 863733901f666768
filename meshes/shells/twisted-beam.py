"""Strip along x that twists about its middle line, region "beam".

The twisted cantilever of MacNeal and Harder: the root's width lies along y, the tip's along z.
Physical curves root, tip; physical point tip-middle where a node lies there.
"""

import runpy
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

grid = runpy.run_path(str(Path(__file__).with_name("grid.py")))

DEFAULTS: dict[str, float] = {
    "length": 12.0,  # [m]
    "width": 1.1,  # [m]
    "twist_deg": 90.0,
    "n_length": 48,
    "n_width": 8,
    "diagonals": 1,  # 0 one way, 1 alternating, 2 the other way
    "distortion": 0.0,  # largest shift of an inner node over the length of a cell
    "seed": 1,  # of these random shifts
}


def build(gmsh: Any, parameters: Mapping[str, Any]) -> None:
    """Fill gmsh's current model; parameters: see DEFAULTS. Raises ValueError."""
    table = grid["checked"](DEFAULTS, parameters)
    length, width = float(table["length"]), float(table["width"])
    twist = np.radians(float(table["twist_deg"]))

    def place(u: Any, v: Any) -> tuple[Any, Any, Any]:
        across = (v - 0.5) * width
        return u * length, across * np.cos(twist * u), across * np.sin(twist * u)

    beam = grid["mapped"]("beam", place, (int(table["n_length"]), int(table["n_width"])), table)
    p = beam.places
    tip = 0.5 * (p[-1, 0] + p[-1, -1])
    grid["write"](gmsh, [beam], {"root": [p[0]], "tip": [p[-1]]}, {"tip-middle": tip})


if __name__ == "__main__":
    grid["show"](build, sys.argv[1:])
