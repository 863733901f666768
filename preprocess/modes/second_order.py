"""Pairs of modes: tables over them, and the second-order motion of what turns with an interface."""

import numpy as np

from ...solver.math.arrays import Array, IntArray


def pairs(m: int) -> tuple[IntArray, IntArray]:
    """Modes of each pair i <= j."""
    return np.triu_indices(m)


def square(values: Array, m: int) -> Array:
    """Values (a, pairs, ...) as symmetric tables (a, m, m, ...)."""
    i, j = pairs(m)
    out = np.empty((len(values), m, m, *values.shape[2:]))
    out[:, i, j] = out[:, j, i] = values
    return out


def turned(turn: Array, arms: Array) -> Array:
    """(a_i x (a_j x d) + a_j x (a_i x d))/2 of points of a rigid interface, (k, 3, pairs) [m].

    Parameters
    ----------
    turn : (3, m) rotation a of the interface in the modes [rad]
    arms : (k, 3) d, from its reference point to the points [m]
    """
    i, j = pairs(turn.shape[1])
    one, other, d = turn.T[i], turn.T[j], arms[:, None]
    moved = 0.5 * (np.cross(one, np.cross(other, d)) + np.cross(other, np.cross(one, d)))
    return np.swapaxes(moved, 1, 2)
