"""Functions of the sides of a triangle, at its integration points.

Side k runs from corner i to j; l are the area coordinates, g their gradients.
"""

import numpy as np

from ...solver.math.arrays import Array
from .triangles import END, POINTS, START, Triangles


def _weights(sign: float) -> Array:
    """Factors of the three gradients in l_i g_j + sign l_j g_i, (point and side, corner)."""
    weights = np.zeros((3, 3, 3))
    for k, (i, j) in enumerate(zip(START, END, strict=True)):
        weights[:, k, j] = POINTS[:, i]
        weights[:, k, i] = sign * POINTS[:, j]
    return weights.reshape(9, 3)


BULGES, EDGES = 4.0 * _weights(+1.0), _weights(-1.0)


def bulge_slopes(t: Triangles) -> Array:
    """Gradient of P_k = 4 l_i l_j, (c, point, side, 2) [1/m]; P_k is 1 in the middle of its
    side."""
    return np.asarray((BULGES @ t.grad).reshape(-1, 3, 3, 2))


def edge_fields(t: Triangles) -> Array:
    """Vector field L_k (l_i g_j - l_j g_i), (c, point, side, 2).

    Its component along side k is 1 on that side, and 0 along the other two.
    """
    return np.asarray((EDGES @ t.grad).reshape(-1, 3, 3, 2) * t.length[:, None, :, None])
