"""Linear elastic response of rich bodies along a base motion.

The base motion is put into the mechanism with rich bodies at q = 0. It leaves the modal loads p.
With the mass M_q of the modes, in which joints, hinges and carried masses have their part, the
modes respond by

    M_q qdd + D qd + K q = p,       quasi-static part eta = K^-1 p.

Resonance and the coupling of neighbours are in it. M_q is that of some output times, constant
between them. Newmark's method with gamma = 0.55 damps what the output times do not resolve.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..dynamics.dense_equations import assemble
from ..dynamics.model import Model, state_size
from ..dynamics.residual import residuals
from ..math.arrays import Array, IntArray
from .base import Base

SAMPLES = 32  # output times at which masses and sensitivities are computed
GAMMA = 0.55


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


def modal_loads(base: Base, model: Model) -> Array:
    """Return the loads (k, n_vel) that the base motion leaves in a model with more modes."""
    y, a = embedded(base, model)
    return residuals(model, base.t, y, a, base.multipliers)


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
        model, elastic = self.model, self.elastic
        stiff = np.setdiff1d(np.arange(model.n_vel), elastic)
        n, c, m = len(stiff), model.n_constraint, len(elastic)
        masses, motions = (
            np.zeros((len(self.at), m, m)),
            np.zeros((len(self.at), model.n_vel + c, m)),
        )
        for s, k in enumerate(self.at.tolist()):
            found = assemble(model, float(self.t[k]), self.y[k])
            A = np.zeros((n + c, n + c))
            A[:n, :n] = found.M[np.ix_(stiff, stiff)]
            A[n:, :n] = found.Phi_q[:, stiff]
            A[:n, n:] = found.Phi_q[:, stiff].T
            right = np.concatenate([found.M[np.ix_(stiff, elastic)], found.Phi_q[:, elastic]])
            follow = -_solved(A, right, regular=self.base.model.redundant == 0)
            masses[s] = found.M[np.ix_(elastic, elastic)] + right.T @ follow
            motions[s, stiff], motions[s, model.n_vel :] = follow[:n], follow[n:]
            motions[s, elastic] = np.eye(m)
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
        masses, K, D = self._blocks[0], self.K, self.D
        t, p = self.t, self.p
        q, v, a = (np.zeros(p.shape) for _ in range(3))
        beta = 0.25 * (GAMMA + 0.5) ** 2
        segment = np.searchsorted(self.at, np.arange(len(t)), side="right") - 1
        solver: Array = np.zeros((0, 0))
        known = (-1, 0.0)
        if self.deformed:
            q[0] = self.eta[0]
        a[0] = _definite(masses[0], p[0] - K @ q[0])
        for k in range(1, len(t)):
            h = float(t[k] - t[k - 1])
            here = (int(segment[k]), round(h, 12))
            if here != known:
                known = here
                solver = _inverse(_positive(masses[here[0]]) + GAMMA * h * D + beta * h * h * K)
            q_p = q[k - 1] + h * v[k - 1] + (0.5 - beta) * h * h * a[k - 1]
            v_p = v[k - 1] + (1.0 - GAMMA) * h * a[k - 1]
            a[k] = solver @ (p[k] - K @ q_p - D @ v_p)
            q[k] = q_p + beta * h * h * a[k]
            v[k] = v_p + GAMMA * h * a[k]
        return q, v, a


def _solved(A: Array, b: Array, *, regular: bool) -> Array:
    if regular:
        try:
            return np.asarray(np.linalg.solve(A, b))
        except np.linalg.LinAlgError:
            pass
    return np.asarray(np.linalg.lstsq(A, b, rcond=1e-10)[0])


def _positive(M: Array) -> Array:
    """Mass without the round-off that makes held directions negative."""
    values, V = np.linalg.eigh(0.5 * (M + M.T))
    return np.asarray((V * np.maximum(values, 1e-12 * values.max(initial=0.0))) @ V.T)


def _inverse(A: Array) -> Array:
    return np.asarray(np.linalg.inv(A))


def _definite(M: Array, b: Array) -> Array:
    return np.asarray(np.linalg.solve(_positive(M), b))


def response(base: Base, model: Model, p: Array, *, deformed: bool = False) -> Response:
    """Return the response to loads p (k, n_vel) of a linear model with rich bodies."""
    elastic = np.concatenate(elastic_columns(model)).astype(np.int64)
    m, at = len(elastic), 0
    K, D = np.zeros((m, m)), np.zeros((m, m))
    for i in range(model.n_body):
        n, two = int(model.n_mode[i]), int(model.square_start[i])
        part = slice(at, at + n)
        K[part, part] = model.K_qq[two : two + n * n].reshape(n, n)
        D[part, part] = model.D_qq[two : two + n * n].reshape(n, n)
        at += n
    y, _ = embedded(base, model)
    samples = np.unique(np.linspace(0, len(base.t) - 1, SAMPLES).astype(np.int64))
    return Response(base, model, y, p[:, elastic], K, D, samples, deformed)
