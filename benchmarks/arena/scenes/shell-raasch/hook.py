"""Raasch's hook in the plane x-y, 20 wide along z: 60 degrees of radius 14, 150 back of radius 46.

A quarter of the cells along the length is on the first arc. Physical curves root, end; point
end-middle where a node lies there.
"""

import runpy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

GRID = Path(__file__).resolve().parents[4] / "meshes/shells/grid.py"
DEFAULTS = {"n_length": 32, "n_width": 32, "diagonals": 1, "distortion": 0.0, "seed": 1}


def place(u: Any, v: Any) -> tuple[Any, Any, Any]:
    """Places for u along the hook and v across it, both 0 to 1."""
    a = np.radians(60.0) * np.minimum(4.0 * u, 1.0)
    b = np.radians(150.0) * np.maximum(4.0 * u - 1.0, 0.0) / 3.0
    at = np.radians(60.0) - b
    x = 14.0 * np.sin(a) + 46.0 * (np.sin(np.radians(60.0)) - np.sin(at))
    y = 14.0 * (1.0 - np.cos(a)) - 46.0 * (np.cos(np.radians(60.0)) - np.cos(at))
    return x, y, 20.0 * v


def build(gmsh: Any, parameters: Mapping[str, Any]) -> None:
    """Fill gmsh's current model. Raises ValueError."""
    grid = runpy.run_path(str(GRID))
    table = grid["checked"](DEFAULTS, parameters)
    hook = grid["mapped"]("hook", place, (int(table["n_length"]), int(table["n_width"])), table)
    p = hook.places
    points = {"end-middle": 0.5 * (p[-1, 0] + p[-1, -1])}
    grid["write"](gmsh, [hook], {"root": [p[0]], "end": [p[-1]]}, points)
