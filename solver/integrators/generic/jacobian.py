"""Jacobian of the derivative by forward differences."""

import numpy as np

from ...math.arrays import Array
from .base import Derivative

ROOT_EPSILON = float(np.sqrt(np.finfo(float).eps))


def increments(y: Array, change: Array, rtol: float, atol: Array) -> Array:
    """Increment of each component, (n,): root of machine epsilon times the component's size.

    Its size is the largest of |y|, the change it makes in one step, and atol / rtol, below
    which it does not count; 1 where all are zero.
    """
    size = np.maximum(np.abs(y), np.abs(change))
    floor = np.where(np.isfinite(atol), atol, 0.0) / rtol
    size = np.maximum(size, floor)
    size[~(size > 0)] = 1.0
    delta = ROOT_EPSILON * size
    return (y + delta) - y


def difference_jacobian(f: Derivative, t: float, y: Array, f_y: Array, delta: Array) -> Array:
    """df/dy by forward differences, (n, n), from f_y = f(t, y) and n more evaluations."""
    J = np.empty((y.size, y.size), order="F")
    moved = y.copy()
    for j in range(y.size):
        moved[j] = y[j] + delta[j]
        J[:, j] = f(t, moved)
        moved[j] = y[j]
    J -= f_y[:, None]
    J /= delta
    return J
