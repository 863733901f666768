"""What each mode contributes to each signal along the linear response."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....dynamics.model.coordinates import move_rows
from ....dynamics.model.model import Model, state_size
from ....math.arrays import Array, IntArray
from ....signals import Recording, Sensor
from .response import Response

MOST_MOVED = 1e-2  # largest coordinate of a difference [m, rad]
# Signals that follow from rates or accelerations of the modes; the others from the modes.
BY_RATES, BY_ACCELERATIONS = ("velocity", "angular_velocity"), ("acceleration", "reaction")


class PerturbedRecording(Recording):
    """States with given accelerations and multipliers, not those of the equations of motion."""

    def __init__(self, model: Model, t: Array, y: Array, rates: Array, multipliers: Array) -> None:
        super().__init__(model, t, y)
        self._given = rates, multipliers

    @property
    def rates(self) -> Array:
        """The given rates (k, n)."""
        return self._given[0]

    @property
    def multipliers(self) -> Array:
        """The given multipliers (k, n_c)."""
        return self._given[1]


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

    @cached_property
    def whole(self) -> Array:
        """Signals (o, k) of the linear response."""
        return np.asarray(self.base + self.response.sum(axis=2))


def effects(found: Response, sensors: Mapping[str, Sensor], kinds: Mapping[str, str]) -> Effects:
    """Return the contributions of all modes to the signals, which have these kinds."""
    q, v, a = found.history
    eta = found.eta
    names, k, m = list(sensors), len(found.t), q.shape[1]
    base = np.zeros((len(names), k))
    whole, static = np.zeros((len(names), k, m)), np.zeros((len(names), k, m))
    plain = _recording(found, np.arange(k, dtype=np.int64))
    for o, name in enumerate(names):
        base[o] = sensors[name].values(plain)
    nothing = np.zeros_like(eta)
    by_order = (
        lambda: (q, eta),
        lambda: (v, np.gradient(eta, found.t, axis=0) if k > 1 else nothing),
        lambda: (a, nothing),
    )
    for order, of in enumerate(((), BY_RATES, BY_ACCELERATIONS)):
        wanted = [
            o
            for o, name in enumerate(names)
            if (kinds[name] in of if of else kinds[name] not in BY_RATES + BY_ACCELERATIONS)
        ]
        if not wanted:
            continue
        response, quasi = by_order[order]()
        size = np.abs(response).max(axis=0, initial=0.0)
        moving = np.flatnonzero(size > 0.0)
        if not moving.size:
            continue
        slopes = _slopes(found, [sensors[names[o]] for o in wanted], moving, order, size[moving])
        over_time = _interpolated(found, slopes)
        for o, slope in zip(wanted, over_time, strict=True):
            whole[o][:, moving] = slope * response[:, moving]
            static[o][:, moving] = slope * quasi[:, moving]
    return Effects(base, whole, static)


def _recording(found: Response, rows: IntArray) -> PerturbedRecording:
    rates, multipliers = _rates(found, rows)
    return PerturbedRecording(found.model, found.t[rows], found.y[rows], rates, multipliers)


def _rates(found: Response, rows: IntArray) -> tuple[Array, Array]:
    model, base = found.model, found.base
    rates = np.zeros((len(rows), state_size(model)))
    for i in range(model.n_body):
        j, own = model.n_pos + int(model.vel_start[i]), int(base.model.vel_start[i])
        rates[:, j : j + 6] = base.accelerations[rows, own : own + 6]
    return rates, base.multipliers[rows]


def _slopes(
    found: Response, sensors: list[Sensor], modes: IntArray, order: int, size: Array
) -> Array:
    """Derivatives (o, s, m) of signals by m modes (order 0), their rates or their accelerations.

    `size` (m,) of their changes. All changes of a sample follow each other in one recording, so
    that angles stay on one branch.
    """
    model, rows, n = found.model, found.at, found.model.n_vel
    motions = found.motions[:, :, modes].transpose(0, 2, 1)  # (s, m, n_vel + n_c)
    step = np.array(size)
    if order == 0:
        largest = np.abs(motions[:, :, :n]).max(axis=(0, 2), initial=0.0)
        step = np.minimum(size, MOST_MOVED / np.maximum(largest, 1e-300))
    sides = np.stack([motions, -motions], axis=2) * step[:, None, None]
    change = np.ascontiguousarray(sides.reshape(-1, sides.shape[-1]))
    each = np.repeat(rows, 2 * len(modes))
    y, (rates, multipliers) = found.y[each], _rates(found, each)
    if order == 0:
        move_rows(model, y, np.ascontiguousarray(change[:, :n]))
    elif order == 1:
        y[:, model.n_pos : model.n_pos + n] += change[:, :n]
    else:
        rates[:, model.n_pos : model.n_pos + n] += change[:, :n]
        multipliers = multipliers + change[:, n:]
    recording = PerturbedRecording(model, found.t[each], y, rates, multipliers)
    values = np.array([sensor.values(recording) for sensor in sensors])
    values = values.reshape(len(sensors), len(rows), len(modes), 2)
    return np.asarray((values[..., 0] - values[..., 1]) / (2.0 * step))


def _interpolated(found: Response, values: Array) -> Array:
    """Values (o, s, m) at the samples, linear between them at all output times, (o, k, m)."""
    t, known = found.t, found.t[found.at]
    if len(known) == 1:
        return np.repeat(values, len(t), axis=1)
    i = np.clip(np.searchsorted(known, t, side="right") - 1, 0, len(known) - 2)
    share = ((t - known[i]) / (known[i + 1] - known[i]))[:, None]
    return np.asarray((1.0 - share) * values[:, i] + share * values[:, i + 1])
