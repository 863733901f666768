"""Generalized-alpha on a Lie group: constraints are solved together with the step."""

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from ...math.arrays import Array
from .alpha_scheme import (
    HYSTERESIS,
    MAX_FACTOR,
    MAX_ITERATIONS,
    MIN_FACTOR,
    SAFETY,
    TOLERANCE,
    scheme,
)
from .base import Dense, Integrator
from .constrained import ConstrainedSystem, Terms
from .hermite import Hermite
from .jacobian import ROOT_EPSILON
from .saddle_lu import SaddleFactors

FORGET, STALLED = 0.998, 100.0  # failures of Newton's iteration: one in five of five hundred
RENEW_AFTER = 3  # steps; younger stiffness is not what keeps Newton's iteration from converging


@dataclass
class _Point:
    """Velocity, accelerations and multipliers at the end of a step."""

    v: Array
    v_d: Array  # the true acceleration
    a: Array  # the algorithm's, which runs behind it by (alpha_f - alpha_m) h
    multipliers: Array
    power: float


class GeneralizedAlpha(Integrator):
    """Generalized-alpha of Arnold and Bruls for M a + Phi_q' lambda = f, Phi = 0.

    Second order; q moves by the group's exponential (`system.move`), so that Euler parameters
    need no constraint of their own. With spectral radius rho at infinity,

        alpha_m = (2 rho - 1) / (rho + 1), alpha_f = rho / (rho + 1),
        gamma = 1/2 + alpha_f - alpha_m, beta = (gamma + 1/2)^2 / 4,
        (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) vdot_1 + alpha_f vdot_0,
        z = h v_0 + h^2 ((1/2 - beta) a_0 + beta a_1),  v_1 = v_0 + h ((1 - gamma) a_0 + gamma a_1).

    Formulations:
      index3  q_1 = q_0 exp(z); Phi(q_1) = 0. Velocities satisfy the constraints to h^2 only, and
              multipliers swing after a change of step.
      ggl     q_1 = q_0 exp(z + p) with p = -J^-1 Phi_q' eta (the position multiplier of Gear,
              Leimkuhler and Gupta); Phi(q_1) = 0 and Phidot(q_1, v_1) = 0. Default.

    Newton's unknowns are z and h^2 lambda: scaled so, the matrix stays well conditioned as h
    tends to zero. Mass and constraint Jacobian come fresh with the first evaluation of each
    step; stiffness and damping, by differences, are kept until the iteration slows down.

    rho = 1 keeps the energy of what it does not resolve, rho = 0 destroys it in one step.

    Parameters
    ----------
    system : the mechanism as closures
    formulation : "ggl" or "index3"
    spectral_radius : rho, 0 to 1
    others : see Integrator. With fixed_step only Newton's iteration uses the tolerances.
    """

    order = 2

    def __init__(
        self,
        system: ConstrainedSystem,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        formulation: str = "ggl",
        spectral_radius: float = 0.8,
        **options: Any,
    ) -> None:
        self._scheme = scheme(formulation, spectral_radius)
        self._system = system
        self._velocity = slice(system.n_pos, system.n_pos + system.n_vel)
        super().__init__(system.derivative, t0, y0, t_end, **options)
        tightest = np.min(self.norm.atol, initial=np.inf, where=np.isfinite(self.norm.atol))
        self._opening = self.norm.rtol + float(tightest)  # of constraints after a correction
        self._K: Array | None = None  # stiffness, damping: none yet
        self._C = np.zeros((system.n_vel, system.n_vel))
        self._failures = 0.0
        self._excess = 0  # iterations beyond the third since then
        self._renewed_at = 0  # count of steps
        self._h_last, self._power_last = 0.0, 0.0
        self._v_dd: Array | None = None  # rate of the acceleration over the last step
        if self.status == "running":
            v_d, multipliers = system.accelerations(self.t, self.y)
            self.counters.evaluations += 1
            power = float(self._f_start[-1])
            self._now = _Point(self.y[self._velocity].copy(), v_d, v_d, multipliers, power)

    def _attempt(self, h: float, t_new: float) -> Array | None:
        start = self._predicted(h)
        found = self._newton(h, t_new, *start)
        self._failures *= FORGET
        if found is None:
            self._failures += 1
            if self._failures > STALLED and self.fixed_step is None:
                self._stalled = (
                    "Newton's iteration fails in one step of five, however short (a smaller "
                    'rtol may help, constraints = "projection" with integrator = "rk8" will),'
                )
            self._h_next = (0.1 if self._not_finite else 0.25) * h
            return None
        y_new, point, factors, terms = found
        v_dd = (point.v_d - self._now.v_d) / h
        if self.fixed_step is None:
            err = self._error(h, y_new, v_dd, factors, terms)
            if not isfinite(err):
                self._refuse_not_finite("the error")
                self._h_next = 0.1 * h
                return None
            factor = SAFETY * max(err, 1e-6) ** (-1 / 3)
            self._h_next = h * max(MIN_FACTOR, min(MAX_FACTOR, factor))
            if err > 1:
                self._not_finite = 0
                self._trouble = f"local error {err:.3g} times the tolerance"
                return None
            if factor >= 1 and self._h_next < HYSTERESIS * h:
                self._h_next = h
        y_new[-1] = self.y[-1] + self._work(h, point.power)
        nearest = self.project(t_new, y_new)
        if nearest is None:
            self._h_next = 0.25 * h
            return None
        self._ends = (self.y, self._now, nearest, point)
        self._power_last = self._now.power
        self._now, self._h_last, self._v_dd = point, h, v_dd
        return nearest

    def _work(self, h: float, power: float) -> float:
        """Work over a step [J]: a parabola through this step's and the last one's powers."""
        now = self._now.power
        work = 0.5 * h * (now + power)
        if self._h_last > 0:
            slope, slope_last = (power - now) / h, (now - self._power_last) / self._h_last
            work -= h**3 / 6 * (slope - slope_last) / (h + self._h_last)
        return work

    def _power(self, t: float, y: Array, terms: Terms) -> float:
        """Power of drives and forces [W]; the step's own multipliers lag behind by h^2."""
        power = float(terms.power[0])
        if np.any(terms.Phi_t):
            self.counters.evaluations += 1
            power += float(self._system.accelerations(t, y)[1] @ terms.Phi_t)
        return power

    def _predicted(self, h: float) -> tuple[Array, _Point]:
        """Step z and the point at its end that Newton's iteration begins with."""
        now = self._now
        a_0 = now.a
        if self._h_last > 0:  # its lag grows and shrinks with the step
            a_0 = now.v_d + (now.a - now.v_d) * (h / self._h_last)
        v_d = now.v_d if self._v_dd is None else now.v_d + h * self._v_dd
        a = (
            (1 - self._scheme.alpha_f) * v_d
            + self._scheme.alpha_f * now.v_d
            - self._scheme.alpha_m * a_0
        ) / (1 - self._scheme.alpha_m)
        z = h * now.v + h * h * ((0.5 - self._scheme.beta) * a_0 + self._scheme.beta * a)
        v = now.v + h * ((1 - self._scheme.gamma) * a_0 + self._scheme.gamma * a)
        return z, _Point(v, v_d, a, now.multipliers.copy(), now.power)

    def _newton(
        self, h: float, t: float, z: Array, start: _Point
    ) -> tuple[Array, _Point, SaddleFactors, Terms] | None:
        """State, point, factors and equations at the step's end; None with `_trouble` set."""
        worn = self._K is None or self._excess > 2 * z.size
        found = self._iterate(h, t, z.copy(), start, renew=worn)
        old = self.counters.steps - self._renewed_at >= RENEW_AFTER
        if found is None and old and not worn and not self._not_finite:
            found = self._iterate(h, t, z.copy(), start, renew=True)
        return found

    def _iterate(
        self, h: float, t: float, z: Array, start: _Point, *, renew: bool
    ) -> tuple[Array, _Point, SaddleFactors, Terms] | None:
        system, n_pos = self._system, self._system.n_pos
        v, v_d, a, multipliers = (
            x.copy() for x in (start.v, start.v_d, start.a, start.multipliers)
        )
        shift = np.zeros_like(z)  # p, by the position multiplier
        y = np.empty(self.n)
        factors: SaddleFactors | None = None
        weight = np.empty(0)
        last = 0.0
        for i in range(1, MAX_ITERATIONS + 1):
            y[:n_pos] = system.move(self.y[:n_pos], z + shift)
            y[self._velocity] = v
            y[-1] = self.y[-1]
            terms = self._terms(t, y)
            if terms is None:
                return None
            if factors is None:
                weight = self.norm.weight(self.y, y)
                if renew:
                    self._renew(h, t, y, terms, v_d, multipliers)
                factors = self._factorise(h, terms)
            unbalanced = h * h * (terms.M @ v_d + terms.Phi_q.T @ multipliers - terms.f)
            opening = h * (terms.Phi_q @ v + terms.Phi_t) / self._scheme.to_v
            d_z, d_multipliers = factors.solve(
                -unbalanced, -opening if self._scheme.stabilised else -terms.Phi
            )
            moved = d_z
            if self._scheme.stabilised:
                d_shift, _ = factors.solve(0 * z, -(terms.Phi + terms.Phi_q @ d_z))
                shift += d_shift
                moved = d_z + d_shift
            z += d_z
            v += (self._scheme.to_v / h) * d_z
            v_d += (self._scheme.to_a / (h * h)) * d_z
            a += d_z / (self._scheme.beta * h * h)
            multipliers += d_multipliers / (h * h)
            size = self._size(y[:n_pos], moved, (self._scheme.to_v / h) * d_z, weight)
            if not isfinite(size):
                self._refuse_not_finite("Newton's iteration")
                return None
            rate = size / last if i > 1 and last > 0 else 0.0
            # the second correction may exceed the first: a prediction can be too good for its J
            if i > 2 and rate >= 1 and size > TOLERANCE:
                break
            if size == 0 or (i > 1 and size * rate / max(1 - rate, 0.1) < TOLERANCE):
                open_rows = np.abs(terms.Phi + terms.Phi_q @ moved)
                if open_rows.max(initial=0.0) > self._opening:
                    break  # no correction closes them: the least-norm solution hides it
                self._excess += max(0, i - 3)
                y[:n_pos] = system.move(self.y[:n_pos], z + shift)
                y[self._velocity] = v
                power = self._power(t, y, terms)
                return y, _Point(v, v_d, a, multipliers, power), factors, terms
            last = size
        self._not_finite = 0
        self._trouble = "the Newton iteration does not converge (or constraints contradict)"
        return None

    def _terms(self, t: float, y: Array) -> Terms | None:
        """Equations at (t, y), counted; None with the reason kept where they cannot be had."""
        self.counters.evaluations += 1
        try:
            terms = self._system.terms(t, y)
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            self._raised = f"{type(error).__name__} in the equations at t = {t:.9g} s: {error}"
            self._refuse_not_finite("the equations")
            return None
        if not (np.isfinite(terms.f).all() and np.isfinite(terms.M).all()):
            self._refuse_not_finite("the equations")
            return None
        return terms

    def _renew(
        self, h: float, t: float, y: Array, terms: Terms, v_d: Array, multipliers: Array
    ) -> None:
        """Stiffness and damping (n, n) of M a + Phi_q' lambda - f by forward differences."""
        system, n_pos, n = self._system, self._system.n_pos, self._system.n_vel
        self._K, self._C = np.zeros((n, n)), np.zeros((n, n))
        here = terms.M @ v_d + terms.Phi_q.T @ multipliers - terms.f
        floor = np.where(np.isfinite(self.norm.atol), self.norm.atol, 0.0)[self._velocity]
        speed = np.maximum(np.abs(y[self._velocity]), floor / self.norm.rtol)
        speed[speed == 0] = 1.0
        for matrix, sizes, of_velocity in (
            (self._K, np.maximum(h * speed, 1e-3), False),
            (self._C, speed, True),
        ):
            for j in range(n):
                step = np.zeros(n)
                step[j] = ROOT_EPSILON * sizes[j]
                near = y.copy()
                if of_velocity:
                    near[self._velocity] += step
                else:
                    near[:n_pos] = system.move(y[:n_pos], step)
                there = self._terms(t, near)
                if there is None:
                    return
                change = there.M @ v_d + there.Phi_q.T @ multipliers - there.f - here
                matrix[:, j] = change / step[j]
        self.counters.jacobians += 1
        self._excess, self._renewed_at = 0, self.counters.steps

    def _factorise(self, h: float, terms: Terms) -> SaddleFactors:
        self.counters.factorisations += 1
        K = 0.0 if self._K is None else self._K
        J = self._scheme.to_a * terms.M + (h * self._scheme.to_v) * self._C + (h * h) * K
        return SaddleFactors(J, terms.Phi_q, self._system.inertia_scale)

    def _size(self, q: Array, step: Array, change: Array, weight: Array) -> float:
        """Size of a small step (n_vel,) and change of velocity (n_vel,) in units of tolerance."""
        both = np.zeros(self.n)
        both[: q.size] = self._system.rates(q, step)
        both[self._velocity] = change
        return self.norm(both * weight)

    def _error(
        self, h: float, y: Array, v_dd: Array, factors: SaddleFactors, terms: Terms
    ) -> float:
        """Local error of positions and velocities.

        h^3 (beta + (alpha_m - alpha_f) / 2 - 1/6) vddot and, from the second step on,
        h^3 (1/12 - (alpha_m - alpha_f)^2 / 2) vdddot; both pass the step's own matrix, which
        takes out what is stiff or against the constraints and damped there anyway. What the
        constraints prescribe is exact at the end of the step, but a cubic within it, off by
        h^4 vdddot / 384.
        """
        no_force = np.zeros(terms.Phi.size)
        mass = self._scheme.to_a * terms.M
        shift, _ = factors.solve(mass @ (h**3 * self._scheme.error_q * v_dd), no_force)
        change = np.zeros_like(shift)
        if self._v_dd is not None:
            v_ddd = 2 * (v_dd - self._v_dd) / (h + self._h_last)
            change, _ = factors.solve(mass @ (h**3 * self._scheme.error_v * v_ddd), no_force)
            prescribed, _ = factors.solve(0 * v_ddd, terms.Phi_q @ v_ddd)
            shift = np.abs(shift) + np.abs(prescribed) * (h**4 / 384)
        weight = self.norm.weight(self.y, y)
        return self._size(y[: self._system.n_pos], shift, change, weight)

    def _dense(self) -> Dense:
        y_0, now, y_1, end = self._ends
        return Hermite(self.t_old, self.h, y_0, self._slope(y_0, now), y_1, self._slope(y_1, end))

    def _slope(self, y: Array, point: _Point) -> Array:
        slope = np.empty(self.n)
        slope[: self._system.n_pos] = self._system.rates(y[: self._system.n_pos], point.v)
        slope[self._velocity] = point.v_d
        slope[-1] = point.power
        return slope
