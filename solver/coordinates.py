"""Position coordinates of a system: their rates, and a step of them along the group.

Velocities are no rates of the position coordinates: a rotation has three of the ones and four
of the others. Everything that moves a mechanism by increments of its velocity coordinates goes
through here, so that Euler parameters keep their length.
"""

import numpy as np

from .compiled import inlined, jit
from .model import Model
from .package.schema import Array
from .rotations import parameter_rate


@inlined
def rates_into(model: Model, y: Array, out: Array) -> None:
    """Fill the rates of positions in out, of state y; the rest of out is left alone."""
    for i in range(model.n_body):
        a, j, m = model.pos_start[i], model.n_pos + model.vel_start[i], model.n_mode[i]
        for k in range(3):
            out[a + k] = y[j + k]
        w0, w1, w2 = 0.5 * y[j + 3], 0.5 * y[j + 4], 0.5 * y[j + 5]
        e0, e1, e2, e3 = y[a + 3], y[a + 4], y[a + 5], y[a + 6]
        out[a + 3] = -e1 * w0 - e2 * w1 - e3 * w2
        out[a + 4] = e0 * w0 - e3 * w1 + e2 * w2
        out[a + 5] = e3 * w0 + e0 * w1 - e1 * w2
        out[a + 6] = -e2 * w0 + e1 * w1 + e0 * w2
        for k in range(m):
            out[a + 7 + k] = y[j + 6 + k]


@jit
def position_rates(model: Model, positions: Array, velocities: Array) -> Array:
    """Return the rates (n_pos,) of positions (n_pos,) at velocities (n_vel,)."""
    out = np.empty(model.n_pos)
    rates_into(model, np.concatenate((positions, velocities)), out)
    return out


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
