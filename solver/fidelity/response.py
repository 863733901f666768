"""Linear elastic response of rich bodies along a base motion.

The base motion is put into the mechanism with rich bodies at q = 0. It leaves the modal loads p.
With the mass M_q of the modes, in which joints, hinges and carried masses have their part, the
modes respond by

    M_q qdd + D qd + K q = p,       quasi-static part eta = K^-1 p.

Resonance and the coupling of neighbours are in it. M_q is that of some output times, constant
between them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..dynamics.dense_equations import masses_and_jacobians
from ..dynamics.model import Model, state_size
from ..dynamics.residual import residuals
from ..math.arrays import Array, IntArray
from .base import Base
from .newmark import newmark
from .ringing import ringing

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
    K, D = np.zeros((m, m)), np.zeros((m, m))
    for i in range(model.n_body):
        n, two = int(model.n_mode[i]), int(model.square_start[i])
        part = slice(at, at + n)
        K[part, part] = model.K_qq[two : two + n * n].reshape(n, n)
        D[part, part] = model.D_qq[two : two + n * n].reshape(n, n)
        at += n
    y, _ = embedded(base, model)
    return Response(base, model, y, p[:, elastic], K, D, samples(base), deformed)
