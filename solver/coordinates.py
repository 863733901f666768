"""Position coordinates of a system: their rates, and a step of them along the group.

Velocities are no rates of the position coordinates: a rotation has three of the ones and four
of the others. Everything that moves a mechanism by increments of its velocity coordinates goes
through here, so that Euler parameters keep their length.
"""

import numpy as np

from .compiled import jit
from .model import Model
from .package.schema import Array
from .rotations import parameter_rate


@jit
def position_rates(model: Model, positions: Array, velocities: Array) -> Array:
    """Return the rates (n_pos,) of positions (n_pos,) at velocities (n_vel,)."""
    rates = np.empty(model.n_pos)
    for i in range(model.n_body):
        a, j, m = model.pos_start[i], model.vel_start[i], model.n_mode[i]
        rates[a : a + 3] = velocities[j : j + 3]
        rates[a + 3 : a + 7] = parameter_rate(positions[a + 3 : a + 7], velocities[j + 3 : j + 6])
        rates[a + 7 : a + 7 + m] = velocities[j + 6 : j + 6 + m]
    return rates


@jit
def moved(model: Model, positions: Array, step: Array) -> Array:
    """Return positions (n_pos,) moved by a step (n_vel,) of the velocity coordinates.

    Translations [m] and modes add up; a rotation vector in body axes [rad] turns the body by
    the exponential map. Euler parameters come out with length one.
    """
    out = positions.copy()
    for i in range(model.n_body):
        a, j, m = model.pos_start[i], model.vel_start[i], model.n_mode[i]
        for k in range(3):
            out[a + k] += step[j + k]
        for k in range(m):
            out[a + 7 + k] += step[j + 6 + k]
        theta = step[j + 3 : j + 6]
        half = 0.5 * np.sqrt(theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2)
        ratio = np.sin(half) / half if half > 1e-8 else 1.0
        p = positions[a + 3 : a + 7]
        turned = np.cos(half) * p + ratio * parameter_rate(p, theta)
        length = np.sqrt(turned[0] ** 2 + turned[1] ** 2 + turned[2] ** 2 + turned[3] ** 2)
        out[a + 3 : a + 7] = turned / length
    return out
