"""Linear elastic response of rich bodies along a base motion."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....dynamics.evaluation.accelerations import masses_and_jacobians
from ....dynamics.evaluation.variations import residuals
from ....dynamics.model.model import Model, modal_matrix, state_size
from ....math.arrays import Array, IntArray
from ....math.compiled import lean
from ..plan import Base

RESOLVED = 0.15  # frequency times step up to which Newmark's method keeps a vibration
MASSLESS = 1e-14  # of the largest inverse squared frequency: a direction that joints hold


@dataclass(frozen=True)
class Ringing:
    """Vibrations k of the modes m after the start.

    Attributes
    ----------
    rate : (m,) rates without them, at the start
    shapes : (m, k) amplitudes of the modes
    w, decay : (k,) frequencies [rad/s] and rates of decay [1/s]
    """

    rate: Array
    shapes: Array
    w: Array
    decay: Array

    def history(self, t: Array) -> tuple[Array, Array, Array]:
        """Return coordinates, rates and accelerations (k, m) at times t from the start."""
        phase = np.outer(t, self.w)
        fading = np.exp(-np.outer(t, self.decay))
        sine, cosine = np.sin(phase) * fading, np.cos(phase) * fading
        q = sine @ self.shapes.T
        return q, cosine @ (self.shapes * self.w).T, -sine @ (self.shapes * self.w**2).T


def ringing(M: Array, K: Array, D: Array, rate: Array, step: float) -> Ringing:
    """Return the vibrations that a start from rest leaves if the quasi-static shape has a `rate`.

    Parameters
    ----------
    M, K, D : (m, m) of the modes
    rate : (m,) of the quasi-static coordinates at the start
    step : between output times [s]
    """
    root = np.linalg.inv(np.linalg.cholesky(K))  # K = C C'
    inverse, U = np.linalg.eigh(root @ (0.5 * (M + M.T)) @ root.T)
    some = inverse > max(MASSLESS * float(inverse[-1]), 1e-300)
    some &= inverse * RESOLVED**2 < step**2
    w, X = 1.0 / np.sqrt(inverse[some]), root.T @ U[:, some]
    moved = X.T @ M @ rate * w  # X has a stiffness of 1
    decay = 0.5 * w**2 * (X * (D @ X)).sum(axis=0)
    return Ringing(X @ (w * moved), -X * moved, w, decay)


GAMMA = 0.55
BETA = 0.25 * (GAMMA + 0.5) ** 2
HELD = 1e-12  # of the largest mass: a direction that joints hold has none


def newmark(
    t: Array,
    p: Array,
    masses: Array,
    at: IntArray,
    K: Array,
    D: Array,
    start: Array | None,
    rate: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Return coordinates, rates and accelerations (k, m) at times t (k,), from rest.

    Parameters
    ----------
    p : (k, m)
    masses, at : (s, m, m) and the s rows of t from which each holds; K, D : (m, m)
    start : (m,) coordinates in which the motion starts, in equilibrium; None: zero
    rate : (m,) rates of the start, with `start`; None: zero
    """
    q, v, a = (np.zeros(p.shape) for _ in range(3))
    if not p.size:
        return q, v, a
    if start is None:
        a[0] = np.linalg.solve(_positive(masses[0]), p[0])
    else:
        q[0] = start
        if rate is not None:
            v[0] = rate
    # The matrix of a step changes with the mass and, rarely, with the step.
    h = np.diff(t, prepend=t[:1])
    segment = np.searchsorted(at, np.arange(len(t)), side="right") - 1
    steps, which = np.unique(
        np.column_stack([segment, np.round(h, 12)])[1:], axis=0, return_inverse=True
    )
    step = steps[:, 1, None, None]
    with_mass = masses[steps[:, 0].astype(np.int64)]
    matrices = with_mass + GAMMA * step * D + BETA * step**2 * K
    solvers = np.asarray(np.linalg.inv(matrices), dtype=np.float64)
    number = np.concatenate([[0], which.ravel()]).astype(np.int64)
    space = np.zeros((3, p.shape[1]))
    p, K, D = (np.ascontiguousarray(part) for part in (p, K, D))
    _march(h, p, K, D, _filled(K, D), solvers, number, q, v, a, space)
    return q, v, a


@lean
def _march(
    h: Array,
    p: Array,
    K: Array,
    D: Array,
    filled: IntArray,
    solvers: Array,
    number: IntArray,
    q: Array,
    v: Array,
    a: Array,
    space: Array,
) -> None:
    """Fill q, v, a (k, m) from row 1; `solvers` (n, m, m) by their `number` (k,).

    K and D are zero outside the columns `filled` (m, 2) of each row.
    """
    m = p.shape[1]
    q_p, v_p, left = space[0], space[1], space[2]
    for k in range(1, p.shape[0]):
        step = h[k]
        for i in range(m):
            q_p[i] = q[k - 1, i] + step * v[k - 1, i] + (0.5 - BETA) * step * step * a[k - 1, i]
            v_p[i] = v[k - 1, i] + (1.0 - GAMMA) * step * a[k - 1, i]
        for i in range(m):
            sum_i = p[k, i]
            for j in range(filled[i, 0], filled[i, 1]):
                sum_i -= K[i, j] * q_p[j] + D[i, j] * v_p[j]
            left[i] = sum_i
        for i in range(m):
            sum_i = 0.0
            for j in range(m):
                sum_i += solvers[number[k], i, j] * left[j]
            a[k, i] = sum_i
            q[k, i] = q_p[i] + BETA * step * step * sum_i
            v[k, i] = v_p[i] + GAMMA * step * sum_i


def _filled(K: Array, D: Array) -> IntArray:
    """Return the first column of each row of K and D that is not zero, and that after the last."""
    m, used = len(K), (K != 0.0) | (D != 0.0)
    some = used.any(axis=1)
    first = np.where(some, used.argmax(axis=1), 0)
    last = np.where(some, m - used[:, ::-1].argmax(axis=1), 0)
    return np.column_stack([first, last]).astype(np.int64)


def _positive(M: Array) -> Array:
    """Mass without the round-off that makes held directions negative."""
    values, V = np.linalg.eigh(0.5 * (M + M.T))
    return np.asarray((V * np.maximum(values, HELD * values[-1])) @ V.T)


LEAST_SAMPLES, MOST_SAMPLES = 12, 32  # output times of masses and sensitivities
TURN = 0.3  # of a body between them, in the mean [rad]


def samples(base: Base) -> IntArray:
    """Return output times (s,) in equal steps, the more the further a body turns."""
    model, turned = base.model, 0.0
    for first in (model.n_pos + model.vel_start + 3).tolist():
        speed = np.linalg.norm(base.y[:, first : first + 3], axis=1)
        turned = max(turned, float(np.trapezoid(speed, base.t)))
    count = 1 + int(np.clip(np.ceil(turned / TURN), LEAST_SAMPLES - 1, MOST_SAMPLES - 1))
    return np.unique(np.linspace(0, len(base.t) - 1, count).astype(np.int64))


def embedded(base: Base, model: Model) -> tuple[Array, Array]:
    """Return states (k, n) and accelerations (k, n_vel) of the base in a model with more modes."""
    k = len(base.t)
    y, a = np.zeros((k, state_size(model))), np.zeros((k, model.n_vel))
    own = base.model
    y[:, model.n_pos + model.n_vel : -1] = base.y[:, own.n_pos + own.n_vel : -1]
    for i in range(model.n_body):
        to, source = int(model.pos_start[i]), int(own.pos_start[i])
        y[:, to : to + 7] = base.y[:, source : source + 7]
        to, source = int(model.vel_start[i]), int(own.vel_start[i])
        a[:, to : to + 6] = base.accelerations[:, source : source + 6]
        y[:, model.n_pos + to : model.n_pos + to + 6] = base.y[
            :, own.n_pos + source : own.n_pos + source + 6
        ]
    return y, a


def elastic_columns(model: Model) -> list[IntArray]:
    """Return the velocity coordinates of the modes of each body."""
    return [
        int(model.vel_start[i]) + 6 + np.arange(int(model.n_mode[i])) for i in range(model.n_body)
    ]


def modal_loads(base: Base, model: Model, rows: IntArray | None = None) -> Array:
    """Return the loads (k, n_vel) that the base motion leaves in a model with more modes.

    At all output times, or at some `rows`.
    """
    y, a = embedded(base, model)
    at = slice(None) if rows is None else rows
    return residuals(model, base.t[at], y[at], a[at], base.multipliers[at])


@dataclass(frozen=True)
class Response:
    """Response of the modes of all bodies, in the order of the velocity coordinates.

    Attributes
    ----------
    model : linear, with all modes that respond
    t : (k,)
    y : (k, n) the base motion, modes zero
    p, K, D : (k, m), (m, m), (m, m) loads, stiffness and damping of the modes
    at : (s,) rows of t where the masses are known
    deformed : the run starts in the quasi-static shape
    """

    base: Base
    model: Model
    y: Array
    p: Array
    K: Array
    D: Array
    at: IntArray
    deformed: bool = False

    @property
    def t(self) -> Array:
        """Output times (k,) [s]."""
        return self.base.t

    @cached_property
    def elastic(self) -> IntArray:
        """Velocity coordinates of all modes, (m,)."""
        return np.concatenate(elastic_columns(self.model)).astype(np.int64)

    @cached_property
    def eta(self) -> Array:
        """Quasi-static response (k, m)."""
        return np.asarray(np.linalg.solve(self.K, self.p.T).T)

    @cached_property
    def _blocks(self) -> tuple[Array, Array]:
        """Mass of the modes (s, m, m), and the motion per unit mode (s, n_vel + n_c, m).

        The motion has the rigid coordinates and multipliers that follow the modes.
        """
        model, e, rows = self.model, self.elastic, self.at
        r = np.setdiff1d(np.arange(model.n_vel), e)
        M, Phi_q = masses_and_jacobians(model, self.t[rows], self.y[rows])
        n, c, s = len(r), model.n_constraint, len(rows)
        A = np.zeros((s, n + c, n + c))
        A[:, :n, :n], A[:, n:, :n] = M[:, r[:, None], r], Phi_q[:, :, r]
        A[:, :n, n:] = A[:, n:, :n].transpose(0, 2, 1)
        right = np.concatenate([M[:, r[:, None], e], Phi_q[:, :, e]], axis=1)
        follow = -_solved(A, right, regular=self.base.model.redundant == 0)
        masses = M[:, e[:, None], e] + right.transpose(0, 2, 1) @ follow
        motions = np.zeros((s, model.n_vel + c, len(e)))
        motions[:, r], motions[:, model.n_vel :] = follow[:, :n], follow[:, n:]
        motions[:, e] = np.eye(len(e))
        return masses, motions

    @property
    def motions(self) -> Array:
        """Motion and multipliers per unit mode at the samples, (s, n_vel + n_c, m)."""
        return self._blocks[1]

    @cached_property
    def history(self) -> tuple[Array, Array, Array]:
        """Modes, rates and accelerations (k, m) by Newmark's method.

        From rest, undeformed or (`deformed`) in the quasi-static shape.
        """
        t, masses = self.t, self._blocks[0]
        if not (self.deformed and self.p.size and len(t) > 2):
            start = self.eta[0] if self.deformed else None
            return newmark(t, self.p, masses, self.at, self.K, self.D, start)
        moving = np.gradient(self.eta[:3], t[:3], axis=0, edge_order=2)[0]
        rings = ringing(masses[0], self.K, self.D, moving, float(t[1] - t[0]))
        smooth = newmark(t, self.p, masses, self.at, self.K, self.D, self.eta[0], rings.rate)
        q, v, a = (one + two for one, two in zip(smooth, rings.history(t - t[0]), strict=True))
        return q, v, a


def _solved(A: Array, b: Array, *, regular: bool) -> Array:
    """Return A^-1 b of all samples; the solution of least norm where A is singular."""
    if regular:
        try:
            return np.asarray(np.linalg.solve(A, b))
        except np.linalg.LinAlgError:
            pass
    pairs = zip(A, b, strict=True)
    return np.array([np.linalg.lstsq(one, two, rcond=1e-10)[0] for one, two in pairs])


def response(base: Base, model: Model, p: Array, *, deformed: bool = False) -> Response:
    """Return the response to loads p (k, n_vel) of a linear model with rich bodies."""
    elastic = np.concatenate(elastic_columns(model)).astype(np.int64)
    m, at = len(elastic), 0
    (K, D), matrices = np.zeros((2, m, m)), (model.K_qq, model.D_qq)
    for i in range(model.n_body):
        part = slice(at, at + int(model.n_mode[i]))
        K[part, part], D[part, part] = (modal_matrix(model, each, i) for each in matrices)
        at = part.stop
    y, _ = embedded(base, model)
    return Response(base, model, y, p[:, elastic], K, D, samples(base), deformed)
