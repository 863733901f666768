"""Error estimate of K by a solution on the same mesh with one degree more."""

import numpy as np

from ...solver.math.arrays import Array

# The error of K falls with the degree of the field, at least with degree^-RATE. This is the rate
# for singular stresses (at the edge of a ply or a re-entrant corner); smooth parts converge
# faster. docs/sections-accuracy.md compares the estimates with true errors.
RATE = 2.1


def error_estimate(K: Array, K_richer: Array, degree: int) -> Array:
    """Expected |error| of each entry of K (6, 6), in its units.

    `K` belongs to a field of some degree, `K_richer` to one degree more on the same mesh. With
    errors proportional to degree^-RATE, their difference is a known fraction of the error of K.
    """
    share = 1.0 - (degree / (degree + 1.0)) ** RATE
    return np.abs(K - K_richer) / share


def scaled(difference: Array, K: Array) -> Array:
    """Entries in units of sqrt(K_ii K_jj), (6, 6): relative errors in any unit of length."""
    size = np.sqrt(np.abs(np.diag(K)))
    return np.abs(difference) / np.outer(size, size)
