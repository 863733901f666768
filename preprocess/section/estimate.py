"""How far K is from the exact one: the same mesh with a field of one degree more."""

import numpy as np

from ...solver.package.schema import Array

# K falls to the exact one as the field gets richer. What the next degree takes off is most of the
# error: all of it where the solution is smooth, about two thirds where stresses are singular (at
# the edge of a ply or a re-entrant corner). With this factor the largest estimate is 1.1 to 2.5
# times the largest error of the reference sections, docs/sections-accuracy.md.
SHARE = 1.75


def error_estimate(K: Array, K_richer: Array) -> Array:
    """Expected |error| of each entry of K (6, 6), in its units.

    `K_richer` is the stiffness on the same mesh with a field of one degree more.
    """
    return SHARE * np.abs(K - K_richer)


def scaled(difference: Array, K: Array) -> Array:
    """Entries in units of sqrt(K_ii K_jj), (6, 6): relative errors in any unit of length."""
    size = np.sqrt(np.abs(np.diag(K)))
    return np.abs(difference) / np.outer(size, size)
