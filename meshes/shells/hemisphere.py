"""Quarter of a hemisphere with a hole around its pole, region "shell", normal outwards.

The pole lies on z; x and y are >= 0. Physical curves equator, hole, side-x (in the plane y = 0)
and side-y (in the plane x = 0); physical points at-x and at-y on the equator.
"""

import runpy
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

grid = runpy.run_path(str(Path(__file__).with_name("grid.py")))

DEFAULTS: dict[str, float] = {
    "radius": 10.0,  # [m]
    "hole_deg": 18.0,  # angle from the pole to the rim of the hole
    "n_around": 16,
    "n_up": 16,
    "diagonals": 1,  # 0 one way, 1 alternating, 2 the other way
    "distortion": 0.0,  # largest shift of an inner node over the length of a cell
    "seed": 1,  # of these random shifts
}


def build(gmsh: Any, parameters: Mapping[str, Any]) -> None:
    """Fill gmsh's current model; parameters: see DEFAULTS. Raises ValueError."""
    table = grid["checked"](DEFAULTS, parameters)
    radius = float(table["radius"])
    height = np.radians(90.0 - float(table["hole_deg"]))

    def place(u: Any, v: Any) -> tuple[Any, Any, Any]:
        around, up = 0.5 * np.pi * u, height * v
        return (
            radius * np.cos(up) * np.cos(around),
            radius * np.cos(up) * np.sin(around),
            radius * np.sin(up),
        )

    shell = grid["mapped"]("shell", place, (int(table["n_around"]), int(table["n_up"])), table)
    p = shell.places
    curves = {"equator": [p[:, 0]], "hole": [p[:, -1]], "side-x": [p[0]], "side-y": [p[-1]]}
    grid["write"](gmsh, [shell], curves, {"at-x": p[0, 0], "at-y": p[-1, 0]})


if __name__ == "__main__":
    grid["show"](build, sys.argv[1:])
