"""Explicit Runge-Kutta methods of Dormand and Prince, orders 8(5,3) and 5(4).

The step loop, the step control and the stiffness test; dormand_prince.py has the coefficients.
"""

from abc import ABC, abstractmethod
from math import isfinite
from typing import Any, ClassVar

import numpy as np

from ...math.arrays import Array
from .advice import SHORTER
from .base import Dense, Integrator
from .dormand_prince import ORDER_5, ORDER_8, Tableau

SAFETY = 0.9
# Of a step that was refused: the largest that follows, and its growth with each step. Where the
# stability limits the steps, the error says so only beyond it (docs/measurements.md). Errors far
# below one say that what was rough is over.
CAUTION, RELAX, RELAX_FAR, FAR_BELOW = 0.9, 1.02, 2.0, 1e-3
STIFF_TESTS = 15  # in a row, before the hint is given
RATE_EVERY = 200  # steps: one per cent of the evaluations of rk8
# Of the limit of stability; and radians by which the direction of an eigenvalue may be wrong, as
# differences over ten tolerances see it.
STABLE, DOUBT = 0.97, 0.01
LIMITS = np.arange(0.05, 10.0, 0.01)  # |h lambda| that are tried
TEST_EVERY = 25  # steps, while nothing looks stiff


class ExplicitRungeKutta(Integrator):
    """Step loop with proportional-integral control, shared by the tableaux below.

    The step factor is SAFETY err^-a err_last^b: a steadies order and b damps the change,
    which saves refusals where the error varies along the motion.

    A hint is left in `hints` when 15 steps without much pause were as large as stability
    on the real axis allows. It is meant for damped fast modes at usual tolerances: with
    tight ones the steps stay below that limit, and undamped modes that are too fast show
    as many refused steps instead.
    """

    tableau: ClassVar[Tableau]
    on_growth = (
        "An explicit method amplifies what is faster than its step: |h w| of the highest mode must "
        "stay below 1.0 (rk5) or 5.9 (rk8), h alpha and h beta of Baumgarte's feedback below 2. "
        f"Take a shorter step ({SHORTER}), an implicit method (radau, generalized-alpha, or gear "
        'with max_order = 2), fewer modes, or constraints = "projection" instead of baumgarte'
    )

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        A, C = self.tableau.A, self.tableau.C
        self._K = np.zeros((self.tableau.D.shape[1], self.n))
        self._stages = [(i, A[i, :i].copy(), self._K[:i], float(C[i])) for i in range(1, C.size)]
        self._work = np.empty(self.n)
        self._f_now = self._f_start
        self._err_last = 1e-4
        self._refused = False
        self._largest = np.inf
        self._suspect = self._clear = 0

    def _go_behind(self, *, jump: bool) -> None:
        self._f_now = np.array(self.derivative(self.t, self.y))

    def _advance(self) -> None:
        keep_stable(self, self.tableau)
        super()._advance()

    def _attempt(self, h: float, t_new: float) -> Array | None:
        K, work, y, tableau = self._K, self._work, self.y, self.tableau
        s = tableau.B.size
        K[0] = self._f_now
        for i, a, K_before, c in self._stages:
            np.dot(a, K_before, out=work)
            work *= h
            work += y
            K[i] = self.derivative(self.t + c * h, work)
        y_new = tableau.B.dot(K[:s])
        y_new *= h
        y_new += y
        err = self._error(h, t_new, y_new)
        if not isfinite(err):
            self._refuse_not_finite("the derivative or the error")
            self._refuse(h, 0.1)
            return None
        if err > 1 and self.fixed_step is None:
            self._trouble = f"local error {err:.3g} times the tolerance"
            self._largest = CAUTION * h
            self._refuse(h, max(tableau.min_factor, SAFETY * err ** (-1 / tableau.exponent)))
            return None
        nearest = self.project(t_new, y_new)
        if nearest is None:
            self._refuse(h, 0.25)
            return None
        if not tableau.first_same_as_last or nearest is not y_new:
            y_new = nearest
            K[s] = self.derivative(t_new, y_new)
            if not isfinite(K[s].dot(K[s])):
                self._refuse_not_finite("the derivative")
                self._refuse(h, 0.1)
                return None
        err = max(err, 1e-8)
        proportional = 1 / tableau.exponent - 0.75 * tableau.integral
        factor = SAFETY * err**-proportional * self._err_last**tableau.integral
        factor = min(1.0 if self._refused else tableau.max_factor, max(tableau.min_factor, factor))
        self._h_next = min(h * factor, self._largest)
        self._largest *= RELAX if err > FAR_BELOW else RELAX_FAR
        self._err_last = max(err, 1e-4)
        self._refused = False
        self._f_now = K[s].copy()
        if self._suspect or self.counters.steps % TEST_EVERY == 0:
            self._test_stiffness(h, y_new)
        self._last = (h, y, y_new)
        return y_new

    def _refuse(self, h: float, factor: float) -> None:
        self._h_next = h * factor
        self._refused = True

    def _test_stiffness(self, h: float, y_new: Array) -> None:
        """Compare |h lambda|, seen from the last stage (also at t_new), with the limit."""
        s = self.tableau.B.size
        weight = self.norm.weight(y_new, y_new)
        distance = self.norm((y_new - self._work) * weight)
        if distance == 0:
            return
        speed = h * self.norm((self._K[s] - self._K[s - 1]) * weight) / distance
        if speed > self.tableau.stability_limit:
            self._suspect, self._clear = self._suspect + 1, 0
            if self._suspect == STIFF_TESTS and not self.hints:
                self.hints.append(stiffness_hint(self.t, h))
        elif self._suspect:
            self._clear += 1
            if self._clear == 6:
                self._suspect = 0

    def _error(self, h: float, t_new: float, y_new: Array) -> float:
        """Local error in units of the tolerance."""
        K, E = self._K, self.tableau.E
        if self.tableau.first_same_as_last:
            K[-1] = self.derivative(t_new, y_new)
        weight = self.norm.weight(self.y, y_new)
        errors = [self.norm(e.dot(K[: e.size]) * weight) for e in E]
        if len(errors) == 1:
            return h * errors[0]
        err5, err3 = errors
        if err5 == 0:
            return 0.0 * err3
        return h * err5 * err5 / (err5 * err5 + 0.01 * err3 * err3) ** 0.5

    def _dense(self) -> Dense:
        h, y_old, y_new = self._last
        K, tableau, s = self._K, self.tableau, self.tableau.B.size + 1
        if tableau.first_same_as_last:
            return Powers(self.t_old, h, y_old, h * tableau.D.dot(K))
        for i, (a, c) in enumerate(zip(tableau.A_extra, tableau.C_extra, strict=True), start=s):
            K[i] = self.derivative(self.t_old + c * h, y_old + h * a[:i].dot(K[:i]))
        step = y_new - y_old
        first = h * K[0] - step
        F = np.vstack((step, first, step - h * K[s - 1] - first, h * tableau.D.dot(K)))
        return Nested(self.t_old, h, y_old, F)


def keep_stable(run: Integrator, tableau: Tableau) -> bool:
    """Bound the steps of a run by its fastest motion, every RATE_EVERY steps; True if it did.

    The error of a body at rest is none whatever the step: longer steps let rounding grow to the
    tolerance, which is relative to the mechanism and may be much of a small deflection.
    """
    steps = run.counters.steps
    if run.fixed_step is not None or not run.vibrates or steps < run.bounded_to:
        return False
    run.bounded_to = steps + RATE_EVERY
    fastest = run.fastest_motion()
    limit = STABLE * stability_limit(tableau, fastest.direction)
    run.max_step = min(run.longest_step, limit / fastest.rate if fastest.rate > 0.0 else np.inf)
    return True


def stability_limit(tableau: Tableau, direction: complex) -> float:
    """Return the first |h lambda| at which a step lets grow what has this direction of lambda.

    A direction near the imaginary axis is taken for less damped by DOUBT than it was found.
    """
    damped = min(direction.real + DOUBT, 0.0)
    z = LIMITS * (damped + 1j * (1.0 - damped**2) ** 0.5)
    power, growth = np.ones(tableau.B.size), np.ones(z.size, dtype=complex)
    for k in range(1, tableau.B.size + 1):  # B A^(k-1) 1 z^k
        growth += (tableau.B @ power) * z**k
        power = tableau.A @ power
    return float(LIMITS[np.argmax(np.abs(growth) > 1.0 + 1e-12)])


def stiffness_hint(t: float, h: float) -> str:
    """Remark on a run whose step h [s] at time t is as long as stability allows."""
    return (
        f"stiff: at t = {t:.6g} s the step {h:.3g} s is limited by stability, not "
        "by accuracy; an implicit method (radau, gear) may need fewer steps"
    )


class RungeKutta8(ExplicitRungeKutta):
    """Dormand-Prince 8(5,3): twelve evaluations a step, dense output of order 7.

    Best where the highest frequency is resolved anyway and accuracy counts. Stable up to
    |h lambda| of about 6, on the imaginary axis as on the real one. The dense output costs
    three more evaluations, spent only in steps where it is asked for.
    """

    name = "rk8"
    local_share = 0.03  # unstable motions amplify errors (tests/verification/test_tumbling_body.py)
    meaning = "explicit Runge-Kutta of order 8"
    place = 3
    order = 8
    tableau = ORDER_8
    points = tuple(sorted({*ORDER_8.C.tolist(), 1.0}))
    limited_above = 2.0


class RungeKutta5(ExplicitRungeKutta):
    """Dormand-Prince 5(4): six evaluations a step, dense output of order 4.

    Stable up to h lambda = -3.3 on the real axis, but only to |h w| of about 1 on the
    imaginary one: undamped modes that are not resolved cost many refused steps.
    """

    name = "rk5"
    local_share = 0.1
    meaning = "explicit Runge-Kutta of order 5"
    place = 4
    order = 5
    tableau = ORDER_5
    points = tuple(sorted({*ORDER_5.C.tolist(), 1.0}))
    limited_above = 0.8


class _Polynomial(ABC):
    """y_old + p(x) with x = (t - t_old) / h; the rows of `c` are the coefficients of p."""

    def __init__(self, t_old: float, h: float, y_old: Array, c: Array) -> None:
        self.t_old, self.h, self.y_old, self.c = t_old, h, y_old, c

    def __call__(self, t: Any) -> Array:
        x = ((np.asarray(t, dtype=float) - self.t_old) / self.h)[..., None]
        return self._change(x, np.zeros(x.shape[:-1] + self.y_old.shape)) + self.y_old

    @abstractmethod
    def _change(self, x: Array, y: Array) -> Array:
        """Value of p at x, from zeros y of the shape of the answer."""


class Nested(_Polynomial):
    """p = x (c0 + (1-x) (c1 + x (c2 + ...)))."""

    def _change(self, x: Array, y: Array) -> Array:
        for i in range(len(self.c) - 1, -1, -1):
            y = (y + self.c[i]) * (x if i % 2 == 0 else 1 - x)
        return y


class Powers(_Polynomial):
    """p = sum over j of c_j x^(j+1)."""

    def _change(self, x: Array, y: Array) -> Array:
        for c_j in self.c[::-1]:
            y = (y + c_j) * x
        return y
