"""Velocities and accelerations of a mechanism that turns as a whole about a fixed axis."""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array
from ...math.rotations import rotation_matrix, skew
from ..model.model import Model


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
    """Return the velocities (n_vel,) of a rigid rotation in positions (n_pos or more,)."""
    out = np.zeros(model.n_vel)
    for i in range(model.n_body):
        a, j = int(model.pos_start[i]), int(model.vel_start[i])
        out[j : j + 3] = np.cross(spin.W, positions[a : a + 3] - spin.point)
        out[j + 3 : j + 6] = rotation_matrix(positions[a + 3 : a + 7]).T @ spin.W
    return out


def spin_accelerations(model: Model, positions: Array, spin: Spin) -> Array:
    """Return the accelerations (n_vel,) of a rigid rotation: W x v of frames, else zero."""
    out = np.zeros(model.n_vel)
    for i in range(model.n_body):
        a, j = int(model.pos_start[i]), int(model.vel_start[i])
        out[j : j + 3] = np.cross(spin.W, np.cross(spin.W, positions[a : a + 3] - spin.point))
    return out


def turned(model: Model, positions: Array, spin: Spin, angle: float) -> Array:
    """Return positions (n_pos,) after a rigid rotation about the axis of the spin [rad]."""
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
