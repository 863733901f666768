"""Position coordinates of a system: their rates, finite increments, and motion in steady spin.

Velocities are not the rates of the position coordinates: a rotation has three velocities and four
Euler parameters. All code that moves a mechanism by increments of its velocity coordinates uses
these functions, so that Euler parameters keep their norm.
"""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ...math.rotations import along_parameters, rotation_matrices, skew
from ..tolerances import SMALL_TURN
from .model import Model


@inlined
def rates_into(model: Model, y: Array, out: Array) -> None:
    """Fill the rates of positions of state y in out; the rest of out does not change.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    out : array (n,), filled at the positions
    """
    for i in range(model.n_body):
        a, j, m = model.pos_start[i], model.n_pos + model.vel_start[i], model.n_mode[i]
        for k in range(3):
            out[a + k] = y[j + k]
        w0, w1, w2 = 0.5 * y[j + 3], 0.5 * y[j + 4], 0.5 * y[j + 5]
        rates = along_parameters(y, a + 3, w0, w1, w2)
        out[a + 3], out[a + 4], out[a + 5], out[a + 6] = rates
        for k in range(m):
            out[a + 7 + k] = y[j + 6 + k]


def position_rates(model: Model, positions: Array, velocities: Array) -> Array:
    """Return the rates (n_pos,) of positions (n_pos,) at velocities (n_vel,).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    positions : positions (n_pos,)
    velocities : velocities (n_vel,)
    """
    out = np.empty(model.n_pos)
    rates_into(model, np.concatenate((positions, velocities)), out)
    return out


def moved(model: Model, positions: Array, step: Array) -> Array:
    """Return positions (n_pos,) moved by a step (n_vel,) of the velocity coordinates.

    Translations [m] and modes are added. A rotation vector in body axes [rad] rotates the body by
    the exponential map. The resulting Euler parameters have norm one.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    positions : positions (n_pos,)
    step : increments of the velocity coordinates (n_vel,) [m, rad]
    """
    out = positions.copy()
    move(model, out, step)
    return out


@lean
def move_rows(model: Model, y: Array, steps: Array) -> None:
    """Move the positions in each row of y (k, n_pos or more) in place by steps (k, n_vel).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : states (k, n_pos or more), moved in place
    steps : increments of the velocity coordinates (k, n_vel) [m, rad]
    """
    for k in range(y.shape[0]):
        move(model, y[k], steps[k])


def displaced(model: Model, y: Array, change: Array) -> Array:
    """Return states (n,) or (k, n) moved by changes (2 n_vel + n_aux,), or one for each.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,) or states (k, n)
    change : increments of positions, velocities and auxiliary states (2 n_vel + n_aux,), one for
        all or one each
    """
    moved, n = np.atleast_2d(y).copy(), model.n_vel
    change = np.broadcast_to(change, (len(moved), np.shape(change)[-1]))
    moved[:, model.n_pos : -1] += change[:, n:]
    move_rows(model, moved, np.ascontiguousarray(change[:, :n]))
    return moved.reshape(y.shape)


@lean
def move(model: Model, y: Array, step: Array) -> None:
    """Move the positions in y (n_pos or more) in place; see `moved`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n_pos or more,), moved in place
    step : increments of the velocity coordinates (n_vel,) [m, rad]
    """
    for i in range(model.n_body):
        a, j, m = model.pos_start[i], model.vel_start[i], model.n_mode[i]
        for k in range(3):
            y[a + k] += step[j + k]
        for k in range(m):
            y[a + 7 + k] += step[j + 6 + k]
        w0, w1, w2 = step[j + 3], step[j + 4], step[j + 5]
        half = 0.5 * np.sqrt(w0 * w0 + w1 * w1 + w2 * w2)
        ratio = 0.5 * np.sin(half) / half if half > SMALL_TURN else 0.5
        p0, p1, p2, p3 = along_parameters(y, a + 3, ratio * w0, ratio * w1, ratio * w2)
        c = np.cos(half)
        p0, p1, p2, p3 = p0 + c * y[a + 3], p1 + c * y[a + 4], p2 + c * y[a + 5], p3 + c * y[a + 6]
        scale = 1.0 / np.sqrt(p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
        y[a + 3], y[a + 4], y[a + 5], y[a + 6] = p0 * scale, p1 * scale, p2 * scale, p3 * scale


class Spin(NamedTuple):
    """A constant spin about a line."""

    axis: Array  # (3,) unit vector, global
    point: Array  # (3,) of the axis, global [m]
    rate: float  # [rad/s]

    @property
    def W(self) -> Array:
        """Angular velocity (3,), global [rad/s]."""
        return self.rate * self.axis


def spin_velocities(model: Model, positions: Array, spin: Spin) -> Array:
    """Return the velocities (n_vel,) of a rigid rotation in positions (n_pos or more,).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    positions : positions (n_pos or more,)
    spin : rotation about a fixed axis
    """
    out = np.zeros(model.n_vel)
    if not spin.rate:
        return out
    frames = positions[np.add.outer(model.pos_start, np.arange(7))]
    moves = (frames[:, :3] - spin.point) @ skew(spin.W).T
    turns = spin.W @ rotation_matrices(frames[:, 3:])
    out[np.add.outer(model.vel_start, np.arange(6))] = np.hstack([moves, turns])
    return out


def spin_accelerations(model: Model, positions: Array, spin: Spin) -> Array:
    """Return the accelerations (n_vel,) of a rigid rotation: W x v of frames, else zero.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    positions : positions (n_pos or more,)
    spin : rotation about a fixed axis
    """
    out, axes, W = np.zeros(model.n_vel), np.arange(3), skew(spin.W)
    arms = positions[np.add.outer(model.pos_start, axes)] - spin.point
    out[np.add.outer(model.vel_start, axes)] = arms @ (W @ W).T
    return out


def turned(model: Model, positions: Array, spin: Spin, angle: float) -> Array:
    """Return positions (n_pos,) after a rigid rotation about the axis of the spin [rad].

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    positions : positions (n_pos,)
    spin : rotation, of which the axis and its point count
    angle : angle of the turn [rad]
    """
    out = np.array(positions, dtype=float)
    c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
    e0, e = c, s * spin.axis
    K = skew(spin.axis)
    A = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
    for i in range(model.n_body):
        a = int(model.pos_start[i])
        out[a : a + 3] = spin.point + A @ (positions[a : a + 3] - spin.point)
        p0, p = positions[a + 3], positions[a + 4 : a + 7]
        out[a + 3] = e0 * p0 - e @ p
        out[a + 4 : a + 7] = e0 * p + p0 * e + np.cross(e, p)
    return out
