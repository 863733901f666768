"""Axes in which the motion is linearised, and the spin of a mechanism that turns as a whole."""

from typing import NamedTuple

import numpy as np

from ...dynamics.evaluation.series import along_solution
from ...dynamics.evaluation.spinning import Spin, spin_accelerations, spin_velocities
from ...dynamics.model.model import Model
from ...math.arrays import Array
from ...math.rotations import rotation_matrix, skew

_ALIKE = 1e-6  # of the largest acceleration by the spin


class Frame(NamedTuple):
    """Rates of displacements and velocities that the turning of axes adds (docs/adr/0020)."""

    T: Array  # (n_vel, n_vel): x' = u + T x
    T_u: Array  # (n_vel, n_vel): u' = a + T_u u


def turning_axes(model: Model, y: Array, W_G: Array) -> Frame:
    """Return the terms of axes that turn at W_G (3,) [rad/s], in state y (n,).

    Translations: -W x in both. Rotations, in body axes that turn at w0: -W x for displacements,
    (w0 - W) x for velocities, so that both are seen from axes that turn at W. Modes: none.
    """
    T, T_u = np.zeros((model.n_vel, model.n_vel)), np.zeros((model.n_vel, model.n_vel))
    for i in range(model.n_body):
        a, j = int(model.pos_start[i]), int(model.vel_start[i])
        A = rotation_matrix(y[a + 3 : a + 7])
        W_B = A.T @ W_G
        w0 = y[model.n_pos + j + 3 : model.n_pos + j + 6]
        T[j : j + 3, j : j + 3] = T_u[j : j + 3, j : j + 3] = -skew(W_G)
        T[j + 3 : j + 6, j + 3 : j + 6] = -skew(W_B)
        T_u[j + 3 : j + 6, j + 3 : j + 6] = skew(w0 - W_B)
    return Frame(T, T_u)


def common_spin(model: Model, t: float, y: Array) -> Spin | None:
    """Return the constant spin at which the whole mechanism turns in state y; None: it does not."""
    v = y[model.n_pos : model.n_pos + model.n_vel]
    first = int(model.vel_start[0])
    a = int(model.pos_start[0])
    W = rotation_matrix(y[a + 3 : a + 7]) @ v[first + 3 : first + 6]
    rate = float(np.linalg.norm(W))
    if rate == 0.0:
        return None
    r0, v0 = y[a : a + 3], v[first : first + 3]
    # the point of the axis nearest to the first frame
    spin = Spin(W / rate, r0 + np.cross(W, v0) / rate**2, rate)
    if np.abs(spin_velocities(model, y, spin) - v).max() > _ALIKE * np.abs(v).max():
        return None
    expected = spin_accelerations(model, y, spin)
    found = along_solution(model, np.full(1, t), y[None])[0][
        0, model.n_pos : model.n_pos + model.n_vel
    ]
    scale = max(float(np.abs(expected).max()), rate**2)
    return spin if np.abs(found - expected).max() <= _ALIKE * scale else None
