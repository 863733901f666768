"""How far K is from the exact one: the same mesh with a field of one degree more."""

import numpy as np

from ...solver.math.arrays import Array

# K falls to the exact one as the field gets richer, at least like degree^-RATE: that is what is
# left where stresses are singular (at the edge of a ply or a re-entrant corner); smooth parts fall
# faster. docs/sections-accuracy.md compares the estimates that follow with true errors.
RATE = 2.1


def error_estimate(K: Array, K_richer: Array, degree: int) -> Array:
    """Expected |error| of each entry of K (6, 6), in its units.

    `K` is of a field of some degree, `K_richer` of one degree more on the same mesh. With errors
    like degree^-RATE, their difference is a known share of the error of K.
    """
    share = 1.0 - (degree / (degree + 1.0)) ** RATE
    return np.abs(K - K_richer) / share


def scaled(difference: Array, K: Array) -> Array:
    """Entries in units of sqrt(K_ii K_jj), (6, 6): relative errors in any unit of length."""
    size = np.sqrt(np.abs(np.diag(K)))
    return np.abs(difference) / np.outer(size, size)
