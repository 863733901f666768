"""Gear's method: backward differentiation formulae of variable order and step."""

from collections.abc import Callable, Sequence
from itertools import accumulate
from math import isfinite
from typing import Any

import numpy as np

from ...math.arrays import Array
from ...math.catalogue import Number
from .advice import IMPLICIT
from .base import Counters, Dense, Derivative, Integrator
from .norm import ErrorNorm
from .tolerances import ROUNDED, SLOW

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
        self, t: float, predicted: Array, psi: Array, gamma: float, weight: Array, *, bent: bool
    ) -> Array | None:
        """y (n,), or None with the reason in `trouble`.

        Parameters
        ----------
        t : end of the step [s]
        predicted : predicted state (n,)
        psi : constant part of the equations (n,)
        gamma : factor of f in y = psi + gamma f(t, y) [s]
        weight : 1 / tolerance (n,)
        bent : f may have kinks: behind one, an old matrix makes the first correction too small
        """
        if self._J is None or self._excess > self._jacobian_cost:
            self._renew(t, predicted)
        while True:
            if self._gamma_lu == 0 or abs(gamma / self._gamma_lu - 1) > DRIFT:
                self._factorise(gamma)
            y = self._iterate(t, predicted, psi, gamma, weight, bent or self._since_measured >= 10)
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
        self, t: float, predicted: Array, psi: Array, gamma: float, weight: Array, measure: bool
    ) -> Array | None:
        y = predicted.copy()
        scale = 2 / (1 + gamma / self._gamma_lu)
        last = 0.0
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
                stalled = rate > SLOW and size > ROUNDED and not self._fresh
                if stalled or (rate >= 1 and size > TOLERANCE):
                    break
                self._rate = min(0.99, max(rate, 0.3 * self._rate))
                self._since_measured = 0
            if size == 0 or (
                (i > 1 or not measure) and size * self._rate / max(1 - self._rate, 0.01) < TOLERANCE
            ):
                self.iterations = i
                self._since_measured += 1
                self._excess += max(0, i - 2)
                return y
            last = size
        self.trouble = "the Newton iteration does not converge"
        return None


def predictor(s: Sequence[float]) -> list[float]:
    """Weights that extrapolate the polynomial through the past points s to the new one."""
    weights = []
    for i, s_i in enumerate(s):
        w = 1.0
        for j, s_j in enumerate(s):
            if j != i:
                w *= s_j / (s_j - s_i)
        weights.append(w)
    return weights


def corrector(s: Sequence[float]) -> tuple[float, list[float]]:
    """Derivative at the new point of the polynomial through it and the k past points s.

    Returns c_0 and b (k) with h y'(t_new) = c_0 (y_new - sum b_i y_i); sum b_i = 1.
    """
    c_0 = sum(1.0 / s_i for s_i in s)
    return c_0, [w / (s_i * c_0) for w, s_i in zip(predictor(s), s, strict=True)]


def error_weights(s: Sequence[float]) -> list[float]:
    """Weights on (new, past points s) of the local error of the formula of order len(s) - 1.

    The error is h times the defect of the formula in y' = f: the divided difference over all
    the points times the distances to the new point, the farthest left out, times h.
    """
    points = [0.0, *s]
    scale = 1.0
    for s_i in s[:-1]:
        scale *= s_i
    weights = []
    for i, s_i in enumerate(points):
        w = scale
        for j, s_j in enumerate(points):
            if j != i:
                w /= s_j - s_i
        weights.append(w)
    return weights


def interpolation(x: float, points: Sequence[float]) -> list[float]:
    """Weights of the polynomial through `points`, taken at x."""
    return predictor([p - x for p in points])


ROOT_EPSILON = float(np.sqrt(np.finfo(float).eps))


def increments(y: Array, change: Array, rtol: float, atol: Array) -> Array:
    """Increment of each component, (n,): root of machine epsilon times the component's size.

    Its size is the largest of |y|, the change it makes in one step, and atol / rtol, below
    which it does not count; 1 where all are zero.

    Parameters
    ----------
    y : state (n,)
    change : its change in one step (n,)
    rtol : relative tolerance
    atol : absolute tolerances (n,)
    """
    size = np.maximum(np.abs(y), np.abs(change))
    floor = np.where(np.isfinite(atol), atol, 0.0) / rtol
    size = np.maximum(size, floor)
    size[~(size > 0)] = 1.0
    delta = ROOT_EPSILON * size
    return (y + delta) - y


def difference_jacobian(f: Derivative, t: float, y: Array, f_y: Array, delta: Array) -> Array:
    """df/dy by forward differences, (n, n), from f_y = f(t, y) and n more evaluations.

    Parameters
    ----------
    f : right-hand side of y' = f(t, y)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    f_y : f(t, y), (n,)
    delta : increment of each component (n,)
    """
    J = np.empty((y.size, y.size), order="F")
    moved = y.copy()
    for j in range(y.size):
        moved[j] = y[j] + delta[j]
        J[:, j] = f(t, moved)
        moved[j] = y[j]
    J -= f_y[:, None]
    J /= delta
    return J


HIGHEST_ORDER = 5
HIGHEST_FIXED_ORDER = 6  # to show what it does; unstable from w h = 0.84 on
KEPT = HIGHEST_FIXED_ORDER + 1  # points of the past
SAFETY = 0.8
MIN_FACTOR, MAX_FACTOR, MAX_FACTOR_ORDER_1 = 0.2, 2.0, 10.0
# Of the mean |h w|: order 3 and above, kept from growing by the error control.
GROWTH_LIMITED = (0.4, 1.0)
# Largest distance of the last past point in the estimate of the error, in steps. Behind a bend of f
# a step is far shorter than those before it, and the estimate would be divided by the distance.
FAR = 30.0
HYSTERESIS = 1.2  # a smaller growth of the step is not worth new factors


class Gear(Integrator):
    """Backward differentiation formulae of order 1 to `max_order`, simplified Newton.

    True variable-coefficient formulae: the corrector is the polynomial through the new
    point and the last k accepted ones at the times where they really are. Codes for large
    systems fix the leading coefficient (or interpolate to equal steps) so that a matrix
    factorisation survives a change of step, and pay with worse stability while steps
    change. Here n is some tens: a factorisation costs less than an evaluation or two of
    f, the Jacobian survives in any case, and no past value is ever re-interpolated.

    Orders 3 to 6 amplify undamped oscillations where w h is below 1.94, 4.71, between
    0.71 and 9.39 and above 0.84: set `max_order = 2` where undamped elastic modes are not
    resolved by the step. Order 2 damps every oscillation.

    Parameters
    ----------
    max_order : cap of the order, 1 to 5
    fixed_order : with fixed_step: use this order, 1 to 6, as soon as enough points are there;
        `max_order` by default
    past : (t (m,), y (m, n)) earlier points of the solution, times ascending to before t0:
        a start without the low orders
    others : see Integrator. With fixed_step only Newton's iteration uses the tolerances.
    """

    name = "gear"
    local_share = 0.001
    meaning = "variable-order BDF (the paper)"
    place = 1
    keys = (
        Number(
            "max_order",
            "",
            "largest order of gear; 2 is stable on any oscillation",
            default=HIGHEST_ORDER,
            least=1,
            most=HIGHEST_ORDER,
            integer=True,
        ),
    )
    order = 1
    on_failure = IMPLICIT
    on_growth = (
        "BDF of order 3 and above amplifies undamped oscillations that the step does not resolve: "
        "take max_order = 2 or radau, which damp all of them, or leave the step to the error "
        "control"
    )

    def __init__(
        self,
        f: Derivative,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        max_order: int = HIGHEST_ORDER,
        fixed_order: int | None = None,
        past: tuple[Sequence[float] | Array, Array] | None = None,
        **options: Any,
    ) -> None:
        for name, value, highest in (
            ("max_order", max_order, HIGHEST_ORDER),
            ("fixed_order", fixed_order, HIGHEST_FIXED_ORDER),
        ):
            if value is not None and value not in range(1, highest + 1):
                raise ValueError(f"{name}: expected an order from 1 to {highest}, got {value!r}")
        super().__init__(f, t0, y0, t_end, **options)
        if fixed_order is not None and self.fixed_step is None:
            raise ValueError("fixed_order: expected a fixed_step beside it")
        self.max_order = max_order if fixed_order is None else fixed_order
        self._times = [self.t]  # newest first, as the rows of _values
        self._steps: list[float] = []  # between them
        self._values = np.zeros((KEPT, self.n))
        self._values[0] = self.y
        if past is not None:
            self._remember_past(*past)
        self._since_change = 0  # steps at this order and step size
        self._failures = 0  # error tests failed in a row
        self._formula_of: tuple[int, list[float]] = (0, [])
        self._newton = SimplifiedNewton(
            self.derivative, self._evaluate_jacobian, self.norm, self.counters, self.n + 1
        )

    def _look_back(self, h_mean: float) -> list[str]:
        if self.max_order < 3:
            return []
        w = self.fastest_motion().rate
        if not GROWTH_LIMITED[0] < h_mean * w < GROWTH_LIMITED[1]:
            return []
        return [
            f"order: the steps average {h_mean:.3g} s, and the fastest motion has a rate of "
            f"{w:.3g} 1/s ({w / 2 / np.pi:.3g} Hz), which longer steps of order 3 to 5 would "
            "amplify; if that motion is of no interest, radau or max_order = 2 damp it and may "
            "need fewer steps; if it is, rk8 resolves it at less cost"
        ]

    def _remember_past(self, t: Sequence[float] | Array, y: Array) -> None:
        times, values = np.asarray(t, dtype=float), np.asarray(y, dtype=float)
        if (
            values.shape != (times.size, self.n)
            or not (np.diff(np.append(times, self.t)) > 0).all()
        ):
            raise ValueError(
                f"past: expected ascending times (m,) before t0 and values (m, {self.n}), "
                f"got shapes {times.shape} and {values.shape}"
            )
        for t_i, y_i in zip(times, values, strict=True):
            self._times.insert(1, float(t_i))
            self._values[2:] = self._values[1:-1]
            self._values[1] = y_i
        del self._times[KEPT:]
        self._steps = list(-np.diff(self._times))

    def _go_behind(self, *, jump: bool) -> None:
        if jump or self.fixed_step is not None:  # the past says nothing about what comes
            self._f_start = np.array(self.derivative(self.t, self.y))
            self._times, self._steps, self._values[0] = [self.t], [], self.y
            self.order, self._since_change = 1, 0

    def _attempt(self, h: float, t_new: float) -> Array | None:
        if self.fixed_step is not None:
            self.order = min(self.max_order, len(self._times))
        k = self.order
        s = self._distances(h, k + 1)
        if (k, s) != self._formula_of:
            self._formula(k, s)
        predicted, psi = self._weights @ self._values[: len(s)]
        if len(self._times) == 1:
            predicted += h * self._f_start
        weight = self.norm.weight(self.y, predicted)
        self._h_try = h
        gamma, bent = h / self._c_0, self.hidden is not None
        y_new = self._newton.solve(t_new, predicted, psi, gamma, weight, bent=bent)
        if y_new is None:
            self._refuse_newton(h)
            return None
        if self.fixed_step is None:
            err = self.norm((y_new - predicted) * weight) * self._err_scale
            if not isfinite(err):
                self._refuse_not_finite("the error")
                self._h_next = 0.1 * h
                return None
            if err > 1:
                self._refuse_error(h, err)
                return None
        y_new = self.project(t_new, y_new)
        if y_new is None:
            self._h_next, self._since_change = 0.25 * h, 0
            return None
        self._remember(t_new, h, y_new)
        self._failures = 0
        if self.fixed_step is None:
            self._choose(h, err, weight)
        return y_new

    def _distances(self, h: float, count: int) -> list[float]:
        """(t_new - t_i) / h of the last points, summed so that equal steps give equal floats."""
        s = [1.0]
        for step in self._steps[: count - 1]:
            s.append(s[-1] + step / h)
        return s

    def _formula(self, k: int, s: list[float]) -> None:
        self._formula_of = (k, s)
        self._c_0, b = corrector(s[:k])
        self._weights = np.zeros((2, len(s)))
        self._weights[0] = predictor(s)
        self._weights[1, : len(b)] = b
        # at the very start the second point is the first again, taken with its derivative
        self._err_scale = 1 / min(s[k], FAR) if len(s) > k else 0.5

    def _refuse_newton(self, h: float) -> None:
        if self._newton.trouble.startswith("not finite"):
            self._refuse_not_finite("the derivative or the Jacobian")
            self._h_next = 0.1 * h
        else:
            self._not_finite = 0
            self._trouble = self._newton.trouble
            self._h_next = 0.25 * h
        self._since_change = 0

    def _refuse_error(self, h: float, err: float) -> None:
        self._not_finite = 0
        self._trouble = f"local error {err:.3g} times the tolerance at order {self.order}"
        self._failures += 1
        self._h_next = h * max(MIN_FACTOR, min(0.9, SAFETY * err ** (-1 / (self.order + 1))))
        if self._failures >= 3:  # the past says nothing about what comes, so forget it
            self.order = 1
        self._since_change = 0

    def _remember(self, t: float, h: float, y: Array) -> None:
        self._times.insert(0, t)
        self._steps.insert(0, h)
        del self._times[KEPT:], self._steps[KEPT - 1 :]
        self._values[1:] = self._values[:-1]
        self._values[0] = y
        self._order_used = self.order

    def _choose(self, h: float, err: float, weight: Array) -> None:
        """Order and size of the next step: the order that allows the largest step."""
        k = self.order
        self._since_change += 1
        self._h_next = h
        if self._since_change <= k:
            return
        s = [distance / h for distance in accumulate(self._steps)]
        best, growth = k, max(err, 1e-10) ** (-1 / (k + 1))
        if k > 1:
            lower = self._estimate(s[:k], weight) ** (-1 / k)
            if lower > growth:
                best, growth = k - 1, lower
        if k < self.max_order and len(s) >= k + 2:
            higher = self._estimate(s[: k + 2], weight) ** (-1 / (k + 2))
            if higher > growth:
                best, growth = k + 1, higher
        factor = min(SAFETY * growth, MAX_FACTOR if best > 1 else MAX_FACTOR_ORDER_1)
        if best != k:
            self.order, self._since_change = best, 0
        if factor >= HYSTERESIS or factor < 1:
            self._h_next, self._since_change = h * max(MIN_FACTOR, factor), 0

    def _estimate(self, s: list[float], weight: Array) -> float:
        """Size of the local error that the order len(s) - 1 would have made."""
        error = np.array(error_weights(s)) @ self._values[: len(s) + 1]
        return max(self.norm(error * weight), 1e-10)

    def _evaluate_jacobian(self, t: float, y: Array) -> Array:
        if self.jacobian is not None:
            return np.asarray(self.jacobian(t, y), dtype=float)
        f_y = np.array(self.derivative(t, y))
        delta = increments(y, self._h_try * f_y, self.norm.rtol, self.norm.atol)
        return difference_jacobian(self.derivative, t, y, f_y, delta)

    def _dense(self) -> Dense:
        count = self._order_used + 1
        return _Interpolant(self._times[:count], self._values[:count].copy())


class _Interpolant:
    """Polynomial through the points that the last step's formula used."""

    def __init__(self, times: list[float], values: Array) -> None:
        self.times, self.values = times, values

    def __call__(self, t: Any) -> Array:
        h = self.times[0] - self.times[1]
        points = [(t_i - self.times[0]) / h for t_i in self.times]
        x = (np.asarray(t, dtype=float) - self.times[0]) / h
        # One time after the other: rounding does not depend on which times are asked for together.
        rows = [np.dot(interpolation(float(x_i), points), self.values) for x_i in x.ravel()]
        return np.reshape(rows, x.shape + self.values.shape[1:])
