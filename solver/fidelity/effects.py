"""What each mode contributes to each signal along the linear response."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..dynamics.coordinates import move_rows
from ..dynamics.model import Model
from ..math.arrays import Array, IntArray
from ..signals import Recording, Sensor
from .response import Response

MOST_MOVED = 1e-2  # largest coordinate of a difference [m, rad]
# Signals that follow from rates or accelerations of the modes; the others from the modes.
BY_RATES, BY_ACCELERATIONS = ("velocity", "angular_velocity"), ("acceleration", "reaction")


class PerturbedRecording(Recording):
    """States with given accelerations and multipliers, not those of the equations of motion."""

    def __init__(self, model: Model, t: Array, y: Array, rates: Array, multipliers: Array) -> None:
        super().__init__(model, t, y)
        self._given = rates, multipliers

    @cached_property
    def _along(self) -> tuple[Array, Array]:
        return self._given


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
    eta_v = np.gradient(eta, found.t, axis=0) if k > 1 else np.zeros_like(eta)
    by_order = ((q, eta), (v, eta_v), (a, np.zeros_like(a)))
    for order, of in enumerate(((), BY_RATES, BY_ACCELERATIONS)):
        wanted = [
            o
            for o, name in enumerate(names)
            if (kinds[name] in of if of else kinds[name] not in BY_RATES + BY_ACCELERATIONS)
        ]
        if not wanted:
            continue
        response, quasi = by_order[order]
        for j in range(m):
            size = float(np.abs(response[:, j]).max(initial=0.0))
            if size == 0.0:
                continue
            slopes = _slopes(found, [sensors[names[o]] for o in wanted], j, order, size)
            for o, slope in zip(wanted, slopes, strict=True):
                over_time = np.interp(found.t, found.t[found.at], slope)
                whole[o, :, j] = over_time * response[:, j]
                static[o, :, j] = over_time * quasi[:, j]
    return Effects(base, whole, static)


def _recording(found: Response, rows: IntArray) -> PerturbedRecording:
    rates, multipliers = _rates(found, rows)
    return PerturbedRecording(found.model, found.t[rows], found.y[rows], rates, multipliers)


def _rates(found: Response, rows: IntArray) -> tuple[Array, Array]:
    model, base = found.model, found.base
    rates = np.zeros((len(rows), model.n_pos + model.n_vel + 1))
    for i in range(model.n_body):
        j, own = model.n_pos + int(model.vel_start[i]), int(base.model.vel_start[i])
        rates[:, j : j + 6] = base.accelerations[rows, own : own + 6]
    return rates, base.multipliers[rows]


def _slopes(found: Response, sensors: list[Sensor], j: int, order: int, size: float) -> list[Array]:
    """Derivatives of signals by mode j (order 0), its rate or its acceleration, at the samples."""
    model, rows, motion = found.model, found.at, found.motions[:, :, j]
    moving = motion[:, : model.n_vel]
    largest = float(np.abs(moving).max())
    step = min(size, MOST_MOVED / max(largest, 1e-300)) if order == 0 else size
    sides = []
    for sign in (1.0, -1.0):
        y, (rates, multipliers) = found.y[rows].copy(), _rates(found, rows)
        change = np.ascontiguousarray(sign * step * moving)
        if order == 0:
            move_rows(model, y, change)
        elif order == 1:
            y[:, model.n_pos : model.n_pos + model.n_vel] += change
        else:
            rates[:, model.n_pos : model.n_pos + model.n_vel] += change
            multipliers = multipliers + sign * step * motion[:, model.n_vel :]
        recording = PerturbedRecording(model, found.t[rows], y, rates, multipliers)
        sides.append([sensor.values(recording) for sensor in sensors])
    return [(up - down) / (2.0 * step) for up, down in zip(*sides, strict=True)]
