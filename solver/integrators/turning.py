"""Rotation of bodies that keeps the steps short: it is a motion that no cutoff takes away."""

from typing import NamedTuple

import numpy as np

from ..dynamics.model import Model
from ..math.arrays import Array

A_TURN = 0.1  # rad in a step, from which on the rotation itself asks for steps this short
# Speed of a rim that no material holds [m/s]: hoops of carbon fibre burst below 3000 m/s.
TOO_FAST = 1e4
GROWN = 10.0  # over the speeds of the start and the drives: these are asked for, not grown


class Turning(NamedTuple):
    """The body that turns fastest."""

    body: int
    spin: float  # [rad/s]
    rim: float  # spin times the radius of gyration about the frame [m/s]


def turning(model: Model, y: Array) -> Turning:
    """Return the body that turns fastest in state y (n,)."""
    first = model.n_pos + np.asarray(model.vel_start)[: model.n_body]
    spins = np.linalg.norm(y[first[:, None] + np.arange(3, 6)], axis=1)
    body = int(np.argmax(spins))
    square = float(np.trace(model.T00[body]) + 0.5 * np.trace(model.J0[body]))
    radius = np.sqrt(square / model.mass[body]) if model.mass[body] > 0.0 else 0.0
    return Turning(body, float(spins[body]), float(spins[body] * radius))
