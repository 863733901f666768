"""The tangent of a motion: the equations of motion linearised along the accepted steps of a run.

With displacements x along the velocity coordinates, changes v of velocities and z of auxiliary
states per unit of each parameter, and D the derivative along (x, v, z) and by the parameter itself,

    Phi_q x + Phi_p = 0,    D Phidot = 0,    x' = v - w x x (rotations, in body axes),
    M v' + Phi_q' lambda' = D(f - M a - Phi_q' lambda),    Phi_q v' = D(gamma - Phi_q a),

at known a and lambda. The constraints make the dependent coordinates follow, so that a tangent is
one of independent coordinates u = x_I, s = v_I and z, by Radau IIA of order 5 on the steps of the
run. It is the derivative of the exact motion, and satisfies the linearised constraints: what steps
and corrections onto the constraints add to the motion has the size of the tolerance. Reasons:
docs/sensitivities.md.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from ...dynamics.analysis.recovery import extent
from ...dynamics.evaluation.accelerations import derivative
from ...dynamics.evaluation.instants import Instants, beyond, sampled
from ...dynamics.evaluation.series import along_solution, quantities
from ...dynamics.model.coordinates import displaced
from ...dynamics.model.model import Model
from ...integrators.compiled.radau_stages import A_INVERSE, POWERS, A, C
from ...integrators.generic.drive import Steps
from ...math.arrays import Array, IntArray
from ..linearisation.differences import units_of
from ..tolerances import LEAST_STEP, STEP
from .linear import Column, Linear, Linearisation, Partials

BATCH = 4_000_000  # numbers of the terms of one batch of steps
NEAR = 1e-6  # of the size of the mechanism: distance from a bend of a force
NODES, STRIDES = 8, (2, 1)  # through which equations are interpolated; steps between them
ROUGH = 1e-5  # of the largest velocity: what interpolated accelerations may miss in a step
GROWN = 4.0  # sum of absolute weights, above which they multiply rounding errors of the equations


class Batch(NamedTuple):
    """Stages of k steps."""

    t: Array  # (k + 1,) ends [s]
    y: Array  # (3 k, n) states at the stages, with their accelerations and multipliers
    a: Array  # (3 k, n_vel)
    multipliers: Array  # (3 k, n_c)
    is_smooth: bool  # whether the equations may be interpolated between the steps

    @property
    def at(self) -> Array:
        """Times of the stages (3 k,) [s]."""
        return (self.t[:-1, None] + np.diff(self.t)[:, None] * C).ravel()


class Equations(NamedTuple):
    """Equations of k steps: those at some states, and weights of these for all stages."""

    t: Array  # (k + 1,) ends [s]
    linear: Linear
    weights: csr_array  # (3 k, nodes)

    def at(self, part: Array, weights: csr_array | None = None) -> Array:
        """Return values at stages of values at the nodes."""
        values = (self.weights if weights is None else weights) @ part.reshape(len(part), -1)
        return np.asarray(values.reshape(len(values), *part.shape[1:]))

    def own(self, times: Array) -> NDArray[np.bool_]:
        """Return which times are within the steps."""
        return np.asarray((times > self.t[0]) & (times <= self.t[-1]))


class Tangent:
    """Carries the derivatives of a state by P parameters along steps.

    Parameters
    ----------
    model : of the run
    columns : the parameters
    y0 : (n,) start
    S : its derivatives
    partials : derivatives of the terms instead of those by the parameters
    bends : numbers of coordinates, and values at which a force along them has a bend
    cuts : instants between which laws of time are smooth; without them equations are not
        interpolated [s]

    Attributes
    ----------
    S : (2 n_vel + n_aux, P) displacements, changes of velocities and of auxiliary states
    units : (n_vel,) of velocity coordinates as shares of the mechanism's size, or angles
    """

    def __init__(
        self,
        model: Model,
        columns: Sequence[Column],
        y0: Array,
        S: Array,
        bends: Sequence[tuple[int, float]] = (),
        cuts: Array | None = None,
        partials: Callable[..., Array] | None = None,
    ) -> None:
        self.model, self.columns, self.S, self._bends = model, columns, S, bends
        self._cuts = cuts
        self._size = extent(model, y0)
        self.units = units_of(model, self._size)
        n = model.n_vel
        per_step = (2 * n + 4 * model.n_constraint + 10) * (3 * n + S.shape[1])
        self._batch = int(np.clip(BATCH // per_step, 1, 500))
        own = Partials(model, columns, stops=bool(bends))
        self.is_still = not S.any() and not own.changes  # no parameter changes anything
        self._partials = own
        self._linear = Linearisation(model, partials or own, self.units)

    def follow(self, steps: Steps, times: Array) -> Array:
        """Carry S over steps without a jump between them.

        Returns S at `times` (m,), behind the beginning and not behind the end of the steps,
        (m, 2 n_vel + n_aux, P).
        """
        values = np.empty((times.size, *self.S.shape))
        for equations in self.equations(steps):
            own = equations.own(times)
            values[own] = self._over(equations, times[own])
        return values

    def equations(self, steps: Steps, *, backwards: bool = False) -> Iterator[Equations]:
        """Yield the equations of steps without a jump between them, batch by batch."""
        parts = self._bent(steps)
        ends = {0, len(steps), *parts, *(i + 1 for i in parts)}
        if self._cuts is not None:
            ends |= set(np.searchsorted(steps.t, self._cuts * (1.0 - 1e-12)).tolist())
        edges = sorted(i for i in ends if i <= len(steps))
        left = [
            (i, min(i + self._batch, end))
            for begin, end in pairwise(edges)
            for i in range(begin, end, self._batch)
        ]
        left = left if backwards else left[::-1]
        while left:
            begin, end = left.pop()
            if begin in parts:
                batch = self._split(steps, begin, parts[begin])
            else:
                batch = self._taken(steps, begin, end)
            nodes, weights = self._nodes(batch)
            at_nodes = (part[nodes] for part in (batch.at, batch.y, batch.a, batch.multipliers))
            away = self._away(batch.at[nodes], batch.y[nodes]) if self._bends else None
            linear = self._linear(*at_nodes, away=away, last=end - begin <= 2)
            if linear is None:  # other independent coordinates sooner
                middle = begin + (end - begin + 1) // 2
                halves = (begin, middle), (middle, end)
                left += halves if backwards else halves[::-1]
                continue
            yield Equations(batch.t, linear, weights)

    def _taken(self, steps: Steps, begin: int, end: int) -> Batch:
        """Return the stages of some steps as the run has left them."""
        assert steps.Z is not None
        assert steps.multipliers is not None
        model, Z = self.model, steps.Z[begin:end]
        h, v = np.diff(steps.t[begin : end + 1]), slice(model.n_pos, model.n_pos + model.n_vel)
        stages = (steps.y[begin:end, None] + Z).reshape(-1, Z.shape[2])
        self._normalise(stages)
        rates = np.einsum("ab,kbi->kai", A_INVERSE, Z[:, :, v]) / h[:, None, None]
        multipliers = steps.multipliers[begin:end, :, : model.n_constraint]
        return Batch(
            steps.t[begin : end + 1],
            stages,
            np.ascontiguousarray(rates.reshape(len(stages), -1)),
            np.ascontiguousarray(multipliers.reshape(len(stages), -1)),
            self._cuts is not None,
        )

    def _split(self, steps: Steps, i: int, parts: Array) -> Batch:
        """Return step i in parts that end at bends, parts (k, 2) of it, from its polynomial.

        Derivatives at the end of a part are those a bit earlier, on this side of the bend.
        """
        model, h = self.model, steps.t[i + 1] - steps.t[i]
        begins = np.concatenate([[0.0], parts[:-1, 0]])
        length = parts[:, 0] - begins
        x = begins[:, None] + length[:, None] * C
        x[:, 2] -= np.clip(parts[:, 1], 1e-4 * length, 0.1 * length)
        t, y = steps.t[i] + x.ravel() * h, self._within(steps, i, x.ravel())
        self._normalise(y)
        rates, multipliers = along_solution(model, t, y)
        a = rates[:, model.n_pos : model.n_pos + model.n_vel]
        ends = np.concatenate([begins, [1.0]])
        return Batch(steps.t[i] + ends * h, y, np.ascontiguousarray(a), multipliers, False)

    def _away(self, t: Array, y: Array) -> Array:
        """Return the distance of states from the nearest bend, in steps of differences (k,)."""
        values = quantities(self.model, t, y)
        gaps = [np.abs(values[:, 2 * number] - level) for number, level in self._bends]
        return np.asarray(np.min(gaps, axis=0) / (STEP * self._size))

    def _normalise(self, y: Array) -> None:
        """Give the Euler parameters of states y (k, n) length one, in place."""
        for a in self.model.pos_start:
            p = y[:, a + 3 : a + 7]
            p /= np.sqrt((p * p).sum(axis=1, keepdims=True))

    def _within(self, steps: Steps, i: int, x: Array) -> Array:
        """Return states at the parts x (k,) of step i."""
        assert steps.Z is not None
        return np.asarray(steps.y[i] + x[:, None] ** np.arange(1, 4) @ POWERS @ steps.Z[i])

    def _bent(self, steps: Steps) -> dict[int, Array]:
        """Return the steps with bends of forces along coordinates, and where: see `_split`."""
        ends: dict[int, list[tuple[float, float]]] = {}
        if not self._bends:
            return {}
        near = NEAR * self._size
        values = quantities(self.model, steps.t, steps.y)
        for number, level in self._bends:
            gap, h = values[:, 2 * number] - level, np.diff(steps.t)
            early = near / np.maximum(np.abs(values[1:, 2 * number + 1]) * h, 1e-300)
            at_end = np.abs(gap) < LEAST_STEP * STEP * self._size
            crossing = (gap[1:] * gap[:-1] < 0.0) & ~at_end[1:] & ~at_end[:-1]
            for i in np.flatnonzero(crossing | at_end[1:]).tolist():
                x = np.array([1.0])
                if crossing[i]:
                    x = self._passage(steps, i, number, level, float(gap[i]))
                ends.setdefault(i, []).append((float(x[0]), float(early[i])))
        return {
            i: np.array(sorted({x: e for x, e in [*parts, (1.0, 0.0), *parts]}.items()))
            for i, parts in ends.items()
        }

    def _passage(self, steps: Steps, i: int, number: int, level: float, before: float) -> Array:
        """Return the part of step i at which a coordinate passes a level, (1,)."""
        x = np.linspace(0.0, 1.0, 65)
        for _ in range(4):
            t = np.full(x.size, steps.t[i])
            there = quantities(self.model, t, self._within(steps, i, x))[:, 2 * number]
            passed = (there - level) * before <= 0.0
            k = max(int(passed.argmax()), 1) if passed.any() else x.size - 1
            x = np.linspace(x[k - 1], x[k], 65)
        return x[:1]

    def _over(self, equations: Equations, times: Array) -> Array:
        """Carry S over a batch; return it at times (m,)."""
        t, linear, weights = equations
        h, at = np.diff(t), equations.at
        k = h.size
        w = self._stages(linear, at(linear.J), at(linear.g), h)
        i = np.clip(np.searchsorted(t, times) - 1, 0, k - 1)
        steps = np.unique(np.concatenate([[k - 1], i, i - 1]))
        steps = steps[steps >= 0]
        own = (3 * steps[:, None] + np.arange(3)).ravel()
        there = weights[own]
        x, v = (
            at(one, there) @ w[own] + at(two, there)
            for one, two in ((linear.x, linear.x_p), (linear.v, linear.v_p))
        )
        S = np.concatenate([x, v, w[own, 2 * linear.n_free :]], axis=1)
        S = S.reshape(steps.size, 3, *self.S.shape)
        S_old = np.concatenate([self.S[None], S[:, 2]])[np.searchsorted(steps, i - 1) + (i > 0)]
        self.S = S[-1, 2]
        powers = ((times - t[i]) / h[i])[:, None] ** np.arange(1, 4) @ POWERS
        inside = S[np.searchsorted(steps, i)] - S_old[:, None]
        return np.asarray(S_old + np.einsum("tk,tkip->tip", powers, inside))

    def _nodes(self, batch: Batch) -> tuple[IntArray, csr_array]:
        """Return the stages at which equations are evaluated, and weights (3 k, nodes) of all.

        Where the motion is smooth, the ends of steps or of every second one are enough: the
        polynomial through eight of them has a higher order than the method. Accelerations, which
        are known at all stages, tell.
        """
        k, at = batch.t.size - 1, batch.at
        asked = np.ones((k, 3), dtype=bool)
        v = batch.y[:, self.model.n_pos : self.model.n_pos + self.model.n_vel]
        most = ROUGH * np.abs(v * self.units).max(initial=0.0)
        for stride in STRIDES if batch.is_smooth and k > NODES else ():
            asked[1:-1] = False
            asked[1:-1:stride, 2] = True
            weights = _through(at, np.flatnonzero(asked))
            a = np.abs(weights @ batch.a[asked.ravel()] - batch.a)
            error = (a * self.units).max(axis=1).reshape(k, 3).max(axis=1) * np.diff(batch.t)
            far = abs(weights).sum(axis=1).reshape(k, 3).max(axis=1) > GROWN
            rough = (error > most) | far
            asked |= rough[:, None]
            if 3 * rough.sum() < asked.sum():
                break
        nodes = np.flatnonzero(asked)
        return nodes, _through(at, nodes)

    def jump(self, t: float, before: Array, after: Array, event: int) -> None:
        """Carry S over an instant at which auxiliary states take other values.

        The instant of an event moves with the parameters by dt = -D gap / rate:
        S+ = D(before + rate dt) - rate+ dt.

        Parameters
        ----------
        t : the instant [s]
        before, after : (n,) state on both sides of it
        event : number of the event; -1: states are sampled at a given time
        """
        model, n = self.model, self.model.n_vel
        first = model.n_pos + n
        which = Instants(model, t + 1.0).sampled_at(t)
        if event >= 0:
            which[model.quantities.event_state[event]] = True
        rates = [
            np.concatenate([y[model.n_pos : first], derivative(model, t, y)[model.n_pos : -1]])
            for y in (before, after)
        ]
        for p, column in enumerate(self.columns):
            h, late = column.h, 0.0
            sides = ((column.minus, -h), (column.plus, h))
            if event >= 0:
                gaps = [
                    beyond(m, t, displaced(model, before, s * self.S[:, p]))[event]
                    for m, s in sides
                ]
                late = -(gaps[1][0] - gaps[0][0]) / (gaps[1][1] + gaps[0][1]) / h
            S = self.S[:, p] + late * rates[0]
            low, high = (
                sampled(m, t + s * late, displaced(model, before, s * S), which)[first:-1]
                for m, s in sides
            )
            S[2 * n :] = np.where(which, (high - low) / (2.0 * h), S[2 * n :])
            self.S[:, p] = S - late * rates[1]

    def _stages(self, linear: Linear, J: Array, g: Array, h: Array) -> Array:
        """Return the independent coordinates at the stages of steps h (k,), (3 k, m, P).

        Where the rates of displacements are the changes of velocities alone, only the others are
        solved for: half the unknowns, of which the time grows with the cube.
        """
        k, m, columns, f = h.size, J.shape[1], g.shape[2], linear.n_free
        f = 0 if linear.J[:, :f, :f].any() else f
        r, hA = m - f, h[:, None, None] * A
        J = J.reshape(k, 3, m, m)[:, :, f:]

        def integrated(rates: Array) -> Array:
            return (hA @ rates.reshape(k, 3, -1)).reshape(k, 3, *rates.shape[-2:])

        # By the state before the step, and by the loads.
        answer = np.empty((k, 3, m, m + columns))
        answer[..., :m], answer[..., m:] = np.eye(m), integrated(g.reshape(k, 3, m, columns))
        answer[:, :, f:] += integrated(J[..., :f] @ answer[:, :, :f])
        rows = np.einsum("kab,kbij->kaibj", hA, J[..., f:])
        rows[..., :f] += np.einsum("kabc,kbij->kaicj", hA[..., None] * hA[:, None], J[..., :f])
        right = answer[:, :, f:].reshape(k, 3 * r, m + columns)
        others = np.linalg.solve(np.eye(3 * r) - rows.reshape(k, 3 * r, 3 * r), right)
        answer[:, :, f:] = others.reshape(k, 3, r, m + columns)
        answer[:, :, :f] += integrated(answer[:, :, f : 2 * f])
        answer = answer.reshape(k, 3 * m, m + columns)
        begin, last = np.empty((k, m, columns)), self.S[linear.kept]
        for i, end in enumerate(answer[:, 2 * m :]):
            begin[i], last = last, end[:, :m] @ last + end[:, m:]
        return (answer[..., :m] @ begin + answer[..., m:]).reshape(3 * k, m, columns)


def _through(t: Array, nodes: IntArray) -> csr_array:
    """Return weights (k, nodes) of values at nodes among times t (k,), for those at all times.

    Of the polynomial through the `NODES` nearest nodes.
    """
    n = min(NODES, nodes.size)
    first = np.clip(np.searchsorted(t[nodes], t) - n // 2, 0, nodes.size - n)
    near = first[:, None] + np.arange(n)
    x = t[nodes[near]]
    others = np.where(np.eye(n, dtype=bool), 1.0, (t[:, None] - x)[:, None])
    apart = np.where(np.eye(n, dtype=bool), 1.0, x[:, :, None] - x[:, None])
    weights = np.prod(others / apart, axis=2)
    return csr_array(
        (weights.ravel(), near.ravel(), np.arange(0, near.size + 1, n)), (t.size, nodes.size)
    )
