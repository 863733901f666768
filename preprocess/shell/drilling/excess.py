"""Difference between the drilling rotation of a corner and the rotation of its triangle."""

import numpy as np

from ....solver.math.arrays import Array
from ..triangles import Triangles


def excess_rotation(t: Triangles) -> Array:
    """tz_i - (v,x - u,y)/2 of each corner, with the linear u and v of the triangle: (c, 3, 9).

    In the degrees of freedom (u, v, tz); zero for a rigid motion and for constant strain.
    """
    T = np.zeros((len(t), 3, 9))
    T[:, :, 0::3] = 0.5 * t.grad[:, None, :, 1]
    T[:, :, 1::3] = -0.5 * t.grad[:, None, :, 0]
    T[:, range(3), range(2, 9, 3)] = 1.0
    return T
