"""One factorisation of [J Phi_q'; Phi_q -e] that several right-hand sides share."""

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from ...math.arrays import Array

REGULARISATION = 1e-9  # e, in scaled equations


class SaddleFactors:
    """Factors of a saddle-point matrix in scaled coordinates; solves for steps and multipliers.

    Rows and columns are scaled by `inertia_scale`, so that units do not matter. The small
    diagonal keeps redundant constraints, and those that lose their effect in a singular
    position, from being divided by: an iteration that repeats the solution for what is left
    over converges to the same answer, with multipliers of least norm.
    """

    def __init__(self, J: Array, Phi_q: Array, inertia_scale: Array) -> None:
        n, n_c = J.shape[0], Phi_q.shape[0]
        self._n = n
        self._columns = 1.0 / np.sqrt(inertia_scale)
        mobility = (Phi_q * Phi_q / inertia_scale).sum(axis=1)
        self._rows = 1.0 / np.sqrt(np.where(mobility > 0.0, mobility, 1.0))
        C = self._rows[:, None] * Phi_q * self._columns
        A = np.empty((n + n_c, n + n_c), order="F")
        A[:n, :n] = self._columns[:, None] * J * self._columns
        A[n:, :n] = C
        A[:n, n:] = C.T
        A[n:, n:] = -REGULARISATION * np.eye(n_c)
        self._lu, self._pivots, _ = dgetrf(A, overwrite_a=1)

    def solve(self, b: Array, c: Array) -> tuple[Array, Array]:
        """Step (n,) and multipliers (n_c,) of J x + Phi_q' mu = b, Phi_q x = c."""
        right = np.concatenate((self._columns * b, self._rows * c))
        x, _ = dgetrs(self._lu, self._pivots, right, overwrite_b=1)
        return self._columns * x[: self._n], self._rows * x[self._n :]
