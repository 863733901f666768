"""Motion of a marker: a frame fixed to a body's interface, or to the ground.

Joints, loads and point masses see bodies through markers only, so each is
written once for rigid bodies, flexible bodies and the ground: the paper's
virtual body with its six constraints already substituted.
"""

from typing import NamedTuple

import numpy as np

from ..compiled import jit
from ..model import Model
from ..package.schema import Array
from ..rotations import (
    cross,
    rotation_matrix,
    skew,
    tangent_map,
    tangent_rate,
    vector_to_matrix,
)
from ..small import mm, mv
from .contractions import contract


class Marker(NamedTuple):
    """Position, velocity and their derivatives of one marker, global components."""

    x: Array  # (3,)                position                  [m]
    A: Array  # (3, 3)              marker axes to global
    v: Array  # (3,)                velocity                  [m/s]
    w: Array  # (3,)                angular velocity          [rad/s]
    J_v: Array  # (3, n)            v = J_v (rdot, w_B, qdot)
    J_w: Array  # (3, n)            w = J_w (rdot, w_B, qdot)
    a: Array  # (3,)                acceleration at zero coordinate accelerations [m/s2]
    alpha: Array  # (3,)            the same of the angular velocity [rad/s2]


@jit
def standing_marker(x: Array, A: Array) -> Marker:
    """Return a marker of the ground at x (3,) with axes A (3, 3)."""
    no_columns = np.zeros((3, 0))
    zero = np.zeros(3)
    return Marker(x, A, zero, zero, no_columns, no_columns, zero, zero)


@jit
def marker_motion(model: Model, k: int, y: Array) -> Marker:
    """Return the motion of marker k in state y (model.py).

    Translation x = r + A (x_k + phi q) is linear in the modes, or of second order on a
    stiffened body (second_order.py). The rotation psi q is taken as a finite rotation vector,
    so that a marker's axes stay orthonormal and its angular velocity is the exact rate of them.
    """
    body = model.marker_body[k]
    if body < 0:
        return standing_marker(model.marker_x[k].copy(), model.marker_A[k].copy())
    m = model.n_mode[body]
    i = model.pos_start[body]
    j = model.n_pos + model.vel_start[body]
    r = y[i : i + 3]
    A = rotation_matrix(y[i + 3 : i + 7])
    q = y[i + 7 : i + 7 + m]
    v = y[j : j + 3]
    w = y[j + 3 : j + 6]
    q_d = y[j + 6 : j + 6 + m]
    s = model.marker_start[k]
    phi = model.marker_phi[s : s + 3 * m].reshape(3, m)
    psi = model.marker_psi[s : s + 3 * m].reshape(3, m)

    b = model.marker_x[k] + mv(phi, q)
    b_d = mv(phi, q_d)
    theta = mv(psi, q)
    theta_d = mv(psi, q_d)
    b_dd = np.zeros(3)
    theta_dd = np.zeros(3)
    h = model.marker_second[k]
    if h >= 0:  # second order: x + phi q + 1/2 q H q, and the rotation vector likewise
        bend = np.empty((6, m))
        parts = np.empty((3, 6))
        contract(model.marker_H[h : h + 6 * m * m].reshape(6 * m, m), q, q_d, bend, parts)
        phi = phi + bend[0:3]
        psi = psi + bend[3:6]
        for a in range(3):
            b[a] += 0.5 * parts[0, a]
            b_d[a] += parts[1, a]
            b_dd[a] = parts[2, a]
            theta[a] += 0.5 * parts[0, 3 + a]
            theta_d[a] += parts[1, 3 + a]
            theta_dd[a] = parts[2, 3 + a]
    T = tangent_map(theta)
    spin = mv(T, theta_d)  # relative angular velocity, body components

    J_v = np.empty((3, 6 + m))
    J_v[:, 0:3] = 0.0
    J_v[0, 0] = J_v[1, 1] = J_v[2, 2] = 1.0
    J_v[:, 3:6] = mm(A, skew(-b))
    J_v[:, 6:] = mm(A, phi)
    J_w = np.empty((3, 6 + m))
    J_w[:, 0:3] = 0.0
    J_w[:, 3:6] = A
    J_w[:, 6:] = mm(A, mm(T, psi))
    rotation = vector_to_matrix(theta)
    return Marker(
        r + mv(A, b),
        mm(A, mm(rotation, model.marker_A[k])),
        v + mv(A, cross(w, b) + b_d),
        mv(A, w + spin),
        J_v,
        J_w,
        mv(A, cross(w, cross(w, b)) + 2.0 * cross(w, b_d) + b_dd),
        mv(A, cross(w, spin) + tangent_rate(theta, theta_d) + mv(T, theta_dd)),
    )
