"""Difference between the drilling rotation of a corner and the rotation of its cell."""

import numpy as np

from ....solver.math.arrays import Array
from ..triangles import Triangles


def excess_rotation(t: Triangles) -> Array:
    """tz_i - (v,x - u,y)/2 of each corner, with the linear u and v of the triangle: (c, 3, 9).

    In the degrees of freedom (u, v, tz); zero for a rigid motion and for constant strain.
    """
    return excess(t.grad)


def excess(grad: Array) -> Array:
    """The same for n corners with gradients (c, n, 2) [1/m] of their functions: (c, n, 3 n)."""
    c, n, _ = grad.shape
    T = np.zeros((c, n, 3 * n))
    T[:, :, 0::3] = 0.5 * grad[:, None, :, 1]
    T[:, :, 1::3] = -0.5 * grad[:, None, :, 0]
    T[:, range(n), range(2, 3 * n, 3)] = 1.0
    return T
