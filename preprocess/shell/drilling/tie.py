"""Coupling of the drilling rotations to the rotation of the triangle (Hughes and Brezzi 1989)."""

import numpy as np

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .contract import Drilling
from .excess import excess_rotation

LINEAR = (1.0 + np.eye(3)) / 12.0  # mean of l_i l_j


def tie(t: Triangles, A: Array, factor: float) -> Array:
    """Stiffness of the energy factor A66/2 int (tz - (v,x - u,y)/2)^2, tz and u, v linear.

    Only rigid motions have no energy: it adds no zero-frequency mode.

    Returns
    -------
    (c, 9, 9)
    """
    T = excess_rotation(t)
    weight = (factor * A[..., 2, 2] * t.area)[:, None, None]
    return np.asarray(np.swapaxes(T, 1, 2) @ (weight * (LINEAR @ T)))


DRILLING = Drilling("tie", tie)
