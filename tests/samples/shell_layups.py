"""Geometry, materials and lay-ups of the composite boxes and plates that CalculiX computed too."""

from typing import Any

WIDTH, HEIGHT, WALL, LENGTH = 0.0242, 0.0136, 0.000762, 1.0  # box, outer [m]
PLATE_LENGTH, PLATE_WIDTH, PLATE_PLY = 0.305, 0.0762, 0.000134  # [m]


def _lamina(E1: float, E2: float, G12: float, G23: float, nu: float, rho: float) -> dict[str, Any]:
    return {
        "kind": "orthotropic",
        **{"E1": E1, "E2": E2, "E3": E2, "G12": G12, "G13": G12, "G23": G23},
        **{"nu12": nu, "nu13": nu, "nu23": nu, "rho": rho},
    }


BOX_MATERIAL = _lamina(142e9, 9.79e9, 6.0e9, 3.447e9, 0.42, 1550.0)
PLATE_MATERIAL = _lamina(98e9, 7.9e9, 5.6e9, 3.086e9, 0.28, 1520.0)

# Plies of each wall, inner to outer, angles from the beam's axis about the outward normal [deg].
BOXES = {
    "0": {"top": [0] * 6, "right": [0] * 6, "bottom": [0] * 6, "left": [0] * 6},
    "cus15": {"top": [15] * 6, "right": [15] * 6, "bottom": [15] * 6, "left": [15] * 6},
    "cas15": {"top": [15] * 6, "right": [-15, 15] * 3, "bottom": [-15] * 6, "left": [15, -15] * 3},
}
PLATES = {
    "[0,0,90]s": [0, 0, 90, 90, 0, 0],
    "[15,15,0]s": [15, 15, 0, 0, 15, 15],
    "[45,45,0]s": [45, 45, 0, 0, 45, 45],
    "[45]3[-45]3": [45, 45, 45, -45, -45, -45],
}
