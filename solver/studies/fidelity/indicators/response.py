"""Linear elastic response of rich bodies along a base motion: what each mode adds to signals."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ....dynamics.analysis.recovery import Recording
from ....dynamics.evaluation import series
from ....dynamics.evaluation.accelerations import masses_and_jacobians
from ....dynamics.evaluation.variations import residuals
from ....dynamics.model.coordinates import move_rows
from ....dynamics.model.model import Model, modal_matrix, state_size
from ....math.arrays import Array, IntArray
from ....signals import Sensor
from ....signals.strength import HELD
from ..comparison import difference
from ..plan import Base

GAMMA = 0.55
BETA = 0.25 * (GAMMA + 0.5) ** 2
HELD_MASS = 1e-12  # of the largest mass: a direction that joints hold has none


def newmark(
    t: Array,
    p: Array,
    masses: Array,
    at: IntArray,
    K: Array,
    D: Array,
    start: Array | None,
) -> tuple[Array, Array, Array]:
    """Return coordinates, rates and accelerations (k, m) at times t (k,), from rest.

    Parameters
    ----------
    p : (k, m)
    masses, at : (s, m, m) and the s rows of t from which each holds; K, D : (m, m)
    start : (2, m) coordinates in which the motion starts, in equilibrium, and rates; None: zero
    """
    k, m = p.shape
    z = np.zeros((k, 3 * m))
    q, v, a = z[:, :m], z[:, m : 2 * m], z[:, 2 * m :]
    if start is None and p.size:  # without the round-off that makes held directions negative
        values, V = np.linalg.eigh(0.5 * (masses[0] + masses[0].T))
        a[0] = np.linalg.solve((V * np.maximum(values, HELD_MASS * values[-1])) @ V.T, p[0])
    elif start is not None:
        q[0], v[0] = start
    # The step z = T z_before + L p changes with the mass and, rarely, with the length of the step.
    h = np.diff(t, prepend=t[:1])
    segment = np.searchsorted(at, np.arange(k), side="right") - 1
    kinds, which = np.unique(
        np.column_stack([segment, np.round(h, 12)])[1:], axis=0, return_inverse=True
    )
    one, none, steps = np.eye(m), np.zeros((m, m)), []
    for s, step in kinds.tolist():
        q_p = np.hstack([one, step * one, (0.5 - BETA) * step**2 * one])
        v_p = np.hstack([none, one, (1.0 - GAMMA) * step * one])
        inverse = np.linalg.inv(masses[int(s)] + GAMMA * step * D + BETA * step**2 * K)
        left = -inverse @ (K @ q_p + D @ v_p)
        share = np.array([BETA * step**2, GAMMA * step, 1.0])
        T = np.vstack([q_p, v_p, np.zeros_like(q_p)]) + np.kron(share[:, None], left)
        steps.append((T, np.kron(share[:, None], inverse)))
    for i, number in enumerate(which.ravel().tolist(), 1):
        T, L = steps[number]
        z[i] = T @ z[i - 1] + L @ p[i]
    return q, v, a


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
    k, own = len(base.t), base.model
    y, a = np.zeros((k, state_size(model))), np.zeros((k, model.n_vel))
    y[:, model.n_pos + model.n_vel : -1] = base.y[:, own.n_pos + own.n_vel : -1]
    for i in range(model.n_body):
        to, source = int(model.pos_start[i]), int(own.pos_start[i])
        y[:, to : to + 7] = base.y[:, source : source + 7]
        to, source = int(model.vel_start[i]), int(own.vel_start[i])
        a[:, to : to + 6] = base.accelerations[:, source : source + 6]
        to, source = model.n_pos + to, own.n_pos + source
        y[:, to : to + 6] = base.y[:, source : source + 6]
    return y, a


def elastic_columns(model: Model) -> list[IntArray]:
    """Return the velocity coordinates of the modes of each body."""
    return [
        int(model.vel_start[i]) + 6 + np.arange(int(model.n_mode[i])) for i in range(model.n_body)
    ]


def modal_loads(base: Base, model: Model, rows: IntArray | None = None) -> Array:
    """Return the loads (k, n_vel) that the base motion leaves in a model with more modes.

    Parameters
    ----------
    base : the base motion
    model : with the same bodies and joints
    rows : (k,) output times; None: all
    """
    y, a = embedded(base, model)
    at = slice(None) if rows is None else rows
    return residuals(model, base.t[at], y[at], a[at], base.multipliers[at])


@dataclass(frozen=True)
class Response:
    """Response of the modes m of all bodies, in the order of the velocity coordinates.

    Attributes
    ----------
    model : linear, with all modes that respond
    y, accelerations : (k, n), (k, n_vel) of the base motion, modes zero
    elastic : (m,) velocity coordinates of the modes
    K : (m, m) their stiffness
    eta : (k, m) quasi-static response
    history : modes, rates and accelerations (k, m) by Newmark's method
    at : (s,) rows of t where the motion per unit mode is known
    motions : (s, n_vel + n_c, m) that motion with its multipliers: what follows the modes
    """

    base: Base
    model: Model
    y: Array
    accelerations: Array
    elastic: IntArray
    K: Array
    eta: Array
    history: tuple[Array, Array, Array]
    at: IntArray
    motions: Array

    @property
    def t(self) -> Array:
        """Output times (k,) [s]."""
        return self.base.t


def response(base: Base, model: Model, p: Array, start: str = "positions") -> Response:
    """Return the response of a linear model with rich bodies.

    Parameters
    ----------
    base : the base motion
    model : with the modes that respond
    p : (k, n_vel) loads at all output times (`modal_loads`)
    start : `solver.start` of the case: undeformed and at rest, or as the loads call for
    """
    e, t, at = np.concatenate(elastic_columns(model)).astype(np.int64), base.t, samples(base)
    m, count = len(e), 0
    (K, D), matrices = np.zeros((2, m, m)), (model.K_qq, model.D_qq)
    for i in range(model.n_body):
        part = slice(count, count + int(model.n_mode[i]))
        K[part, part], D[part, part] = (modal_matrix(model, each, i) for each in matrices)
        count = part.stop
    y, accelerations = embedded(base, model)
    p = p[:, e]
    eta = np.asarray(np.linalg.solve(K, p.T).T)
    # What follows a unit of each mode: the coordinates r of the frames, and the multipliers.
    r = np.setdiff1d(np.arange(model.n_vel), e)
    M, Phi_q = masses_and_jacobians(model, t[at], y[at])
    n, c = len(r), model.n_constraint
    A = np.zeros((len(at), n + c, n + c))
    A[:, :n, :n], A[:, n:, :n] = M[:, r[:, None], r], Phi_q[:, :, r]
    A[:, :n, n:] = A[:, n:, :n].transpose(0, 2, 1)
    right = np.concatenate([M[:, r[:, None], e], Phi_q[:, :, e]], axis=1)
    follow = -_solved(A, right, regular=base.model.redundant == 0)
    masses = M[:, e[:, None], e] + right.transpose(0, 2, 1) @ follow
    motions = np.zeros((len(at), model.n_vel + c, m))
    motions[:, r], motions[:, model.n_vel :] = follow[:, :n], follow[:, n:]
    motions[:, e] = np.eye(m)
    first = None if start == "positions" else np.array([eta[0], np.zeros(m)])
    if first is not None and start == "quasi-static" and len(t) > 2:
        first[1] = np.gradient(eta[:3], t[:3], axis=0, edge_order=2)[0]
    history = newmark(t, p, masses, at, K, D, first)
    return Response(base, model, y, accelerations, e, K, eta, history, at, motions)


def _solved(A: Array, b: Array, *, regular: bool) -> Array:
    """Return A^-1 b of all samples; the solution of least norm where A is singular."""
    if regular:
        try:
            return np.asarray(np.linalg.solve(A, b))
        except np.linalg.LinAlgError:
            pass
    pairs = zip(A, b, strict=True)
    return np.array([np.linalg.lstsq(one, two, rcond=1e-10)[0] for one, two in pairs])


MOST_MOVED = 1e-2  # largest coordinate of a difference [m, rad]
# Signals that follow from rates or accelerations of the modes; the others from the modes.
ORDER = {"velocity": 1, "angular_velocity": 1, "acceleration": 2, "reaction": 2}


@dataclass(frozen=True)
class Effects:
    """Contributions to signals at the output times.

    Attributes
    ----------
    base : (o, k) signals of the base motion
    response : (o, k, m) contribution of each mode by the linear response
    static : (o, k, m) that of its quasi-static part
    """

    base: Array
    response: Array
    static: Array

    @property
    def whole(self) -> Array:
        """Signals (o, k) of the linear response."""
        return np.asarray(self.base + self.response.sum(axis=2))


def effects(
    response: Response,
    sensors: Mapping[str, Sensor],
    kinds: Mapping[str, str],
    bent: Collection[str] = (),
) -> Effects:
    """Return the contributions of all modes to the signals.

    Parameters
    ----------
    response : of the modes
    sensors : of the o signals, by name
    kinds : of the signals, by name
    bent : signals of elastic coordinates that are not linear near zero, as exposures: they are
        linearised at the response instead of the undeformed body
    """
    (q, v, a), eta, t = response.history, response.eta, response.t
    every, plain = list(sensors.values()), _recording(response, np.arange(len(t)))
    base = np.array([sensor.values(plain) for sensor in every]).reshape(len(every), len(t))
    whole, static = np.zeros((2, *base.shape, q.shape[1]))
    nothing = np.zeros_like(eta)
    eta_d = np.gradient(eta, t, axis=0) if len(t) > 1 else nothing
    for order, (history, quasi) in enumerate(((q, eta), (v, eta_d), (a, nothing))):
        wanted = [
            o
            for o, name in enumerate(sensors)
            if ORDER.get(kinds[name], 0) == order and name not in bent
        ]
        size = np.abs(history).max(axis=0, initial=0.0)
        moving = np.flatnonzero(size > 0.0)
        if wanted and moving.size:
            slopes = _slopes(response, [every[o] for o in wanted], moving, order, size[moving])
            for o, slope in zip(wanted, slopes, strict=True):
                whole[o][:, moving] = slope * history[:, moving]
                static[o][:, moving] = slope * quasi[:, moving]
    for o, name in enumerate(sensors):
        if name in bent:
            values, slope = _at_response(response, every[o])
            whole[o], static[o] = slope * q, slope * eta
            base[o] = values - whole[o].sum(axis=1)
    return Effects(base, whole, static)


def _recording(
    response: Response, rows: IntArray, change: Array | None = None, order: int = 0
) -> Recording:
    """Return the base motion at rows (r,) with changes (r, n_vel + n_c), if any.

    Of positions (`order` 0), velocities (1), or accelerations and multipliers (2).
    """
    model, y = response.model, response.y[rows]
    n, multipliers = model.n_vel, response.base.multipliers[rows]
    rates, v = np.zeros_like(y), slice(model.n_pos, model.n_pos + model.n_vel)
    rates[:, v] = response.accelerations[rows]
    if change is not None and order == 0:
        move_rows(model, y, np.ascontiguousarray(change[:, :n]))
    elif change is not None and order == 1:
        y[:, v] += change[:, :n]
    elif change is not None:
        rates[:, v] += change[:, :n]
        multipliers = multipliers + change[:, n:]
    recording = Recording(model, response.t[rows], y)
    recording.along = series.Along(rates, multipliers, series.balance(model, recording.t, y))
    return recording


def _slopes(
    response: Response, sensors: list[Sensor], modes: IntArray, order: int, size: Array
) -> Array:
    """Derivatives (o, k, m) of signals by m modes (order 0), their rates or their accelerations.

    Differences at the samples with changes of `size` (m,), linear between the samples. All changes
    of a sample follow each other in one recording, so that angles stay on one branch.
    """
    motions = response.motions[:, :, modes].transpose(0, 2, 1)  # (s, m, n_vel + n_c)
    step = np.array(size)
    if order == 0:
        largest = np.abs(motions[:, :, : response.model.n_vel]).max(axis=(0, 2), initial=0.0)
        step = np.minimum(size, MOST_MOVED / np.maximum(largest, 1e-300))
    sides = np.stack([motions, -motions], axis=2) * step[:, None, None]
    each = np.repeat(response.at, 2 * len(modes))
    recording = _recording(response, each, sides.reshape(len(each), -1), order)
    values = np.array([sensor.values(recording) for sensor in sensors])
    values = values.reshape(len(sensors), len(response.at), len(modes), 2)
    values = (values[..., 0] - values[..., 1]) / (2.0 * step)
    t, known = response.t, response.t[response.at]
    if len(known) == 1:
        return np.repeat(values, len(t), axis=1)
    i = np.clip(np.searchsorted(known, t, side="right") - 1, 0, len(known) - 2)
    share = ((t - known[i]) / (known[i + 1] - known[i]))[:, None]
    return np.asarray((1.0 - share) * values[:, i] + share * values[:, i + 1])


RELATIVE_STEP = 1e-4  # of differences, of the largest value of a mode


def _at_response(response: Response, sensor: Sensor) -> tuple[Array, Array]:
    """Return a signal (k,) of the elastic coordinates at the response, and its slopes (k, m)."""
    q, memory = response.history[0], dict[Any, Any]({HELD: {}})  # points that govern there
    change = np.zeros((len(q), response.model.n_vel))

    def values(modes: Array) -> Array:
        y = response.y.copy()
        change[:, response.elastic] = modes
        move_rows(response.model, y, change)
        return sensor.values(Recording(response.model, response.t, y, memory))

    here, slopes = values(q), np.zeros_like(q)
    step = RELATIVE_STEP * np.abs(q).max(axis=0, initial=0.0)
    for j in np.flatnonzero(step).tolist():
        h = step * (np.arange(len(step)) == j)
        slopes[:, j] = (values(q + h) - values(q - h)) / (2.0 * step[j])
    return here, slopes


@dataclass(frozen=True)
class Mode:
    """A mode of a rich package: body, label, and whether it is a vibration."""

    body: str
    label: str
    vibration: bool


@dataclass(frozen=True)
class Indicators:
    """Losses by mode and kind.

    Attributes
    ----------
    names : signals
    scale : (o,) size of each signal
    modes : m of the modes that respond
    effects : their contributions
    stiffening : (o,) loss without geometric stiffening, of the scale
    spin : largest spin over the first frequency of the clamped body, by body
    amplified : (o,) error of each signal over the tolerance that causes it
    quiet : (o,) the signals that are rounding; their scale is the size of what they are near
    """

    names: list[str]
    metric: str
    scale: Array
    modes: list[Mode]
    effects: Effects
    stiffening: Array
    spin: dict[str, float]
    amplified: Array
    quiet: npt.NDArray[np.bool_]

    def loss(self, lost: Array) -> Array:
        """Return the error (..., o) that lost contributions (..., o, k) cause, of the scale."""
        whole = self.effects.whole
        return difference(self.metric, whole, whole - lost) / self.scale

    def worth(self, static: Mapping[str, bool]) -> Array:
        """Return the loss of each mode alone, the largest of all signals, (m,)."""
        lost = self.effects.response - self.effects.static * self._has(static)
        size = np.abs(lost).max(axis=1) / self.scale[:, None]
        return np.asarray(size.max(axis=0, initial=0.0))

    def _has(self, static: Mapping[str, bool]) -> Array:
        return np.array([float(static.get(mode.body, False)) for mode in self.modes])

    def ranked(self, body: str) -> tuple[str, ...]:
        """Return the labels of the vibrations of a body, largest loss first."""
        worth = self.worth({})
        order = np.argsort(-worth, kind="stable")
        mine = [self.modes[i] for i in order.tolist()]
        return tuple(mode.label for mode in mine if mode.body == body and mode.vibration)
