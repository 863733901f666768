"""Which mode at one speed is which at the next: left vectors of one, right vectors of the other."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from ...math.arrays import Array, IntArray
from .modes import Modes
from .state_space import StateSpace

_LEAST = 0.1  # overlap below which a mode has no successor


class Vectors(NamedTuple):
    """Modes in coordinates that all speeds share."""

    right: Array  # (2 n_vel + n_a, k) displacements, changes of velocity, other states
    left: Array  # (2 n_vel + n_a, k), with left^H right = 1 for each mode


class Match(NamedTuple):
    """Successors of the modes of one speed at another."""

    successor: IntArray  # (k,) number of the mode; -1: none
    overlap: Array  # (k,) 1: the same shape


def vectors_of(space: StateSpace, modes: Modes) -> Vectors:
    """Return right and left vectors in the coordinates of displacements and velocities."""
    n = space.n_free
    x, u = space.displacements(modes.right), space.velocities(modes.right)
    left, more = space.free.Z_left.T, slice(2 * n, None)
    return Vectors(
        np.vstack([x, u, modes.right[more]]),
        np.vstack([left @ modes.left[:n], left @ modes.left[n : 2 * n], modes.left[more]]),
    )


def match(one: Vectors, two: Vectors) -> Match:
    """Return the assignment of modes with the largest sum of overlaps.

    The overlap of mode i with mode j is sqrt(|l_i^H r_j| |l_j^H r_i|), of r_j or its conjugate:
    in axes that turn, a whirl may go on in the other direction.
    """
    k = one.right.shape[1]
    successor, overlap = np.full(k, -1, dtype=np.int64), np.zeros(k)
    if k == 0 or two.right.shape[1] == 0:
        return Match(successor, overlap)
    found = np.maximum(
        _overlaps(one, two), _overlaps(one, Vectors(two.right.conj(), two.left.conj()))
    )
    rows, columns = linear_sum_assignment(-np.minimum(found, 1.0))
    for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
        if found[i, j] >= _LEAST:
            successor[i], overlap[i] = j, min(float(found[i, j]), 1.0)
    return Match(successor, overlap)


def _overlaps(one: Vectors, two: Vectors) -> Array:
    forward = np.abs(one.left.conj().T @ two.right)
    backward = np.abs(two.left.conj().T @ one.right).T
    found = np.sqrt(forward * backward)
    return np.where(np.isfinite(found), found, 0.0)
