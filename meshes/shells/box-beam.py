"""Middle surface of a rectangular box along x, regions top, right, bottom, left, normals outwards.

y runs along the width, z along the height; right lies at y > 0. Physical curves root (x = 0), tip
with its parts tip-top and so on, and the edges along the beam: top-right, right-bottom,
bottom-left, left-top. The defaults are the 320 triangles of the paper, one cell across each wall.
"""

import runpy
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

grid = runpy.run_path(str(Path(__file__).with_name("grid.py")))

DEFAULTS: dict[str, float] = {
    "length": 1.0,  # [m]
    "width": 0.0242,  # outer, along y [m]
    "height": 0.0136,  # outer, along z [m]
    "wall": 0.000762,  # thickness [m]
    "n_length": 40,
    "n_width": 1,  # cells across the top and bottom walls
    "n_height": 1,  # cells across the side walls
    "diagonals": 1,  # 0 one way, 1 alternating, 2 the other way
    "distortion": 0.0,  # largest shift of an inner node over the length of a cell
    "seed": 1,  # of these random shifts
}


def build(gmsh: Any, parameters: Mapping[str, Any]) -> None:
    """Fill gmsh's current model; parameters: see DEFAULTS. Raises ValueError."""
    table = grid["checked"](DEFAULTS, parameters)
    half_width = 0.5 * (float(table["width"]) - float(table["wall"]))
    half_height = 0.5 * (float(table["height"]) - float(table["wall"]))
    length = float(table["length"])
    # clockwise seen from the tip, so that x times the way around points outwards
    ring = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1], [-1, 1]]) * [half_width, half_height]
    across = int(table["n_width"]), int(table["n_height"])
    walls = []
    for row, name in enumerate(("top", "right", "bottom", "left")):
        a, b = ring[row], ring[row + 1]

        def place(u: Any, v: Any, a: Any = a, b: Any = b) -> tuple[Any, Any, Any]:
            return u * length, a[0] + v * (b[0] - a[0]), a[1] + v * (b[1] - a[1])

        n = int(table["n_length"]), across[row % 2]
        walls.append(grid["mapped"](name, place, n, {**table, "seed": int(table["seed"]) + row}))
    curves = {
        "root": [wall.places[0] for wall in walls],
        "tip": [wall.places[-1] for wall in walls],
    }
    for wall in walls:
        curves[f"tip-{wall.region}"] = [wall.places[-1]]
    for wall, following in zip(walls, [*walls[1:], walls[0]], strict=True):
        curves[f"{wall.region}-{following.region}"] = [wall.places[:, -1]]
    grid["write"](gmsh, walls, curves, {})


if __name__ == "__main__":
    grid["show"](build, sys.argv[1:])
