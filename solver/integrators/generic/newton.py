"""Simplified Newton iteration for y = psi + gamma f(t, y) with a Jacobian kept over steps."""

from collections.abc import Callable
from math import isfinite

import numpy as np

from ...math.arrays import Array
from .base import Counters, Derivative
from .norm import ErrorNorm

MAX_ITERATIONS = 4
TOLERANCE = 0.1  # of the local error allowed, left over by the iteration
DRIFT = 0.1  # of gamma, up to which an old factorisation serves


class SimplifiedNewton:
    """Solve y = psi + gamma f(t, y); Jacobian and factors of I - gamma J are kept.

    Factors made for another gamma serve while gamma has drifted little, the correction
    then being scaled by 2 / (1 + gamma / gamma_lu): a compromise between fast components
    (which want gamma_lu / gamma) and slow ones. The Jacobian is renewed when the iteration
    fails with an old one, and when iterations beyond the second have cost as many
    evaluations as a new Jacobian would. The rate of convergence is carried from step to
    step, so that one iteration can be enough; it is measured afresh every few steps.
    """

    def __init__(
        self,
        f: Derivative,
        jacobian: Callable[[float, Array], Array],
        norm: ErrorNorm,
        counters: Counters,
        jacobian_cost: int,
    ) -> None:
        self._f, self._jacobian, self._norm, self._counters = f, jacobian, norm, counters
        self._jacobian_cost = jacobian_cost
        self._J: Array | None = None
        self._fresh = False  # J belongs to the present attempt
        self._gamma_lu = 0.0  # 0: no factors
        self._lu: Array = np.empty((0, 0))
        self._pivots: Array = np.empty(0)
        self._rate = 1.0
        self._since_measured = 0
        self._excess = 0
        self.iterations = 0
        self.trouble = ""
        # Here: SciPy's linear algebra takes 0.1 s to import, and few integrators use it.
        from scipy.linalg.lapack import dgetrf, dgetrs

        self._lu_factor, self._lu_solve = dgetrf, dgetrs

    def solve(
        self, t: float, predicted: Array, psi: Array, gamma: float, weight: Array
    ) -> Array | None:
        """y (n,), or None with the reason in `trouble`."""
        if self._J is None or self._excess > self._jacobian_cost:
            self._renew(t, predicted)
        while True:
            if self._gamma_lu == 0 or abs(gamma / self._gamma_lu - 1) > DRIFT:
                self._factorise(gamma)
            y = self._iterate(t, predicted, psi, gamma, weight)
            if y is not None:
                self._fresh = False
                return y
            if self._fresh:
                if self.trouble.startswith("not finite"):
                    self._J = None
                self._fresh = False
                return None
            self._renew(t, predicted)

    def _renew(self, t: float, y: Array) -> None:
        self._J = self._jacobian(t, y)
        self._counters.jacobians += 1
        self._fresh, self._excess, self._rate, self._gamma_lu = True, 0, 1.0, 0.0

    def _factorise(self, gamma: float) -> None:
        matrix = np.array(self._J, order="F")
        matrix *= -gamma
        np.einsum("ii->i", matrix)[:] += 1.0
        self._lu, self._pivots, _ = self._lu_factor(matrix, overwrite_a=1)
        self._counters.factorisations += 1
        self._gamma_lu = gamma

    def _iterate(
        self, t: float, predicted: Array, psi: Array, gamma: float, weight: Array
    ) -> Array | None:
        y = predicted.copy()
        scale = 2 / (1 + gamma / self._gamma_lu)
        last = 0.0
        measure = self._since_measured >= 10
        for i in range(1, MAX_ITERATIONS + 1):
            correction = self._f(t, y) * gamma
            correction += psi
            correction -= y
            correction, _ = self._lu_solve(self._lu, self._pivots, correction, overwrite_b=1)
            correction *= scale
            size = self._norm(correction * weight)
            if not isfinite(size):
                self.trouble = "not finite (inf or nan): the derivative or the Jacobian"
                return None
            y += correction
            if i > 1:
                rate = size / last if last > 0 else 0.0
                if rate >= 1 and size > TOLERANCE:
                    break
                self._rate = min(0.99, max(rate, 0.3 * self._rate))
                self._since_measured = 0
            if size == 0 or (
                (i > 1 or not measure) and size * self._rate / max(1 - self._rate, 0.1) < TOLERANCE
            ):
                self.iterations = i
                self._since_measured += 1
                self._excess += max(0, i - 2)
                return y
            last = size
        self.trouble = "the Newton iteration does not converge"
        return None
