"""Test of a factorised matrix for singularity.

A factorisation rarely fails on a singular matrix: with rounding, the last pivot is about 1e-16 of
the others, of either sign. The solution for a random load shows the singularity. Scaled by the
diagonal, which removes the units, it is about 1e15 times as large as the load.
"""

import numpy as np

from ...solver.math.arrays import Array
from ...solver.math.definite import REGULAR

LARGEST_GROWTH = 1.0 / REGULAR


class RandomLoad:
    """A random load; its solution shows whether the matrix is regular.

    Attributes
    ----------
    load : (n,) right-hand side to solve for
    """

    def __init__(self, diagonal: Array) -> None:
        """`diagonal` (n,) of the matrix."""
        self._scale = np.sqrt(np.abs(diagonal))
        self._z = np.random.default_rng(0).standard_normal(len(diagonal))
        self.load: Array = self._scale * self._z

    def is_regular(self, solution: Array) -> bool:
        """True if the matrix that gave this solution (n,) of the load is regular."""
        return self.growth(solution) < LARGEST_GROWTH

    def growth(self, solution: Array) -> float:
        """Size of the scaled solution (n,) over that of the load."""
        return float(np.linalg.norm(self._scale * solution) / np.linalg.norm(self._z))
