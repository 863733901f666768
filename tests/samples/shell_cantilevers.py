"""Laminated cantilevers as shell problems: box beams and plates."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from samples.shell_layups import (
    BOX_MATERIAL,
    BOXES,
    HEIGHT,
    PLATE_MATERIAL,
    PLATE_PLY,
    PLATES,
    WALL,
    WIDTH,
)
from samples.shell_model import Model, Problem, laminate

Array = NDArray[np.float64]


def box(n: Any, layup: str) -> Problem:
    mesh = {"n_length": n[0], "n_width": n[1], "n_height": n[2]}
    stacks = {
        wall: laminate("ply", plies, WALL, "energy-1d") for wall, plies in BOXES[layup].items()
    }
    model = Model("box-beam", mesh, {"ply": BOX_MATERIAL}, stacks, {w: w for w in stacks}, {})
    model.axis = [1.0, 0.0, 0.0]
    model.supports = {"root": {"at": "root", "fixed": "all"}}
    model.loads = {
        "Fz": {"tip": {"at": "tip", "force": [0.0, 0.0, 1.0]}},
        "Fy": {"tip": {"at": "tip", "force": [0.0, 1.0, 0.0]}},
        "T": torque(),
    }
    model.frequencies = {"count": 6}

    def read(solved: Any) -> Array:
        pushed = [solved.work(case) for case in ("Fz", "Fy", "T")]
        return np.array([*solved.frequencies[:6], *pushed])

    return model, read


def torque() -> dict[str, Any]:
    """Unit moment about x as an even shear flow around the tip, by walls."""
    flow = 1.0 / (2.0 * (WIDTH - WALL) * (HEIGHT - WALL))
    against = {"top": [0, -1, 0], "right": [0, 0, 1], "bottom": [0, 1, 0], "left": [0, 0, -1]}
    return {
        wall: {"at": f"tip-{wall}", "force_per_length": [flow * x for x in direction]}
        for wall, direction in against.items()
    }


def cantilever(n: Any, layup: str) -> Problem:
    plies = [float(angle) for angle in PLATES[layup]]
    mesh = {"length": 0.305, "width": 0.0762, "n_length": n[0], "n_width": n[1]}
    stack = laminate("ply", plies, PLATE_PLY * len(plies), "energy-1d")
    materials = {"ply": PLATE_MATERIAL}
    model = Model("plate", mesh, materials, {"wall": stack}, {"all": "wall"}, {})
    model.supports = {"root": {"at": "left", "fixed": "all"}}
    model.loads = {"Fz": {"tip": {"at": "right", "force": [0.0, 0.0, 1.0]}}}
    model.frequencies = {"count": 6}

    def read(solved: Any) -> Array:
        return np.array([*solved.frequencies[:6], solved.probe("right-middle", "uz")])

    return model, read
