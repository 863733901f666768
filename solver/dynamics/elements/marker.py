"""Motion of the markers: frames fixed to a body's interface, or to the ground.

Joints and loads use only markers, so each is written once for rigid bodies,
flexible bodies and the ground. A marker is the paper's virtual body with its six constraints
substituted.
"""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ...math.rotations import (
    about,
    column,
    cross3,
    dot3,
    put_column,
    rotation_into,
    sum3,
    tangent_coefficients,
    tangent_rate,
    triple,
    turned,
)
from ..model.model import Model, Workspace
from ..model.motion import (
    ACCELERATION,
    AXES,
    N_MOTION,
    PLACE,
    SPIN,
    SPIN_RATE,
    VELOCITY,
    bend_marker,
    put,
    stand,
)


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


@inlined
def evaluate_markers(model: Model, work: Workspace, y: Array) -> None:
    """Fill the motions of all markers of joints and force elements in state y.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    """
    for n in range(model.layout.marker_used.shape[0]):
        k = model.layout.marker_used[n]
        move_marker(model, k, y, work.A[model.marker_body[k]], work.motion[k], work.J_m[k])


def marker_motion(model: Model, k: int, y: Array) -> Marker:
    """Return the motion of marker k in state y (model.py), in new arrays.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    k : number of the marker
    y : state (n,), as in dynamics/model/model.py
    """
    motion, J_m = single_motion(model, k, y)
    return Marker(
        motion[PLACE:AXES],
        motion[AXES:VELOCITY].reshape(3, 3),
        motion[VELOCITY:SPIN],
        motion[SPIN:ACCELERATION],
        J_m[:3],
        J_m[3:],
        motion[ACCELERATION:SPIN_RATE],
        motion[SPIN_RATE:],
    )


def single_motion(model: Model, k: int, y: Array) -> tuple[Array, Array]:
    """Return the row of motion.py (24,) and the Jacobian (6, n) of marker k in state y.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    k : number of the marker
    y : state (n,), as in dynamics/model/model.py
    """
    body = model.marker_body[k]
    n = 6 + model.n_mode[body] if body >= 0 else 0
    motion, J_m = np.zeros(N_MOTION), np.zeros((6, n))
    if body >= 0:
        A = np.empty((3, 3))
        p = model.pos_start[body] + 3
        rotation_into(y[p : p + 4], A)
        move_marker(model, k, y, A, motion, J_m)
    else:
        stand(motion, model.marker_x[k], model.marker_A[k])
    return motion, J_m


@lean
def move_marker(model: Model, k: int, y: Array, A: Array, motion: Array, J_m: Array) -> None:
    """Fill motion (24,) and Jacobian J_m (6, n) of marker k on a body with rotation matrix A.

    The translation x = r + A (x_k + phi q) is linear in the modes, or of second order on a
    stiffened body (floating_frame.py). The rotation psi q is a finite rotation vector,
    so the marker axes stay orthonormal and the angular velocity is their exact rate.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    k : number of the marker
    y : state (n,), as in dynamics/model/model.py
    A : rotation matrix of its body (3, 3)
    motion : motion of the marker (24,), to fill
    J_m : its Jacobian (6, n) by the velocities of the body, to fill
    """
    body = model.marker_body[k]
    m = model.n_mode[body]
    i = model.pos_start[body]
    j = model.n_pos + model.vel_start[body]
    w = triple(y[j + 3 : j + 6])
    s = model.marker_start[k]
    b0, b1, b2 = triple(model.marker_x[k])
    d0, d1, d2 = 0.0, 0.0, 0.0
    t0, t1, t2 = 0.0, 0.0, 0.0
    u0, u1, u2 = 0.0, 0.0, 0.0
    b_dd = theta_dd = (0.0, 0.0, 0.0)  # of second order, at steady modal rates
    second = model.marker_second[k]
    bends = second >= 0
    if bends:
        modes, rates = y[i + 7 : i + 7 + m], y[j + 6 : j + 6 + m]
        H, used = model.marker_H, model.marker_H_used[k]
        h, h_d, b_dd = bend_marker(H, second, used, 0, modes, rates, J_m)
        b0, b1, b2 = sum3((b0, b1, b2), h)
        d0, d1, d2 = h_d
        (t0, t1, t2), (u0, u1, u2), theta_dd = bend_marker(H, second, used, 3, modes, rates, J_m)
    for n in range(m):
        q, q_d = y[i + 7 + n], y[j + 6 + n]
        p0 = model.marker_phi[s + n]
        p1 = model.marker_phi[s + m + n]
        p2 = model.marker_phi[s + 2 * m + n]
        b0 += p0 * q
        b1 += p1 * q
        b2 += p2 * q
        d0 += p0 * q_d
        d1 += p1 * q_d
        d2 += p2 * q_d
        slope = (p0, p1, p2)
        if bends:
            slope = sum3(slope, column(J_m, 6 + n))
        put_column(J_m, 0, 6 + n, turned(A, slope))
        p0 = model.marker_psi[s + n]
        p1 = model.marker_psi[s + m + n]
        p2 = model.marker_psi[s + 2 * m + n]
        t0 += p0 * q
        t1 += p1 * q
        t2 += p2 * q
        u0 += p0 * q_d
        u1 += p1 * q_d
        u2 += p2 * q_d
    b, b_d = (b0, b1, b2), (d0, d1, d2)
    theta, theta_d = (t0, t1, t2), (u0, u1, u2)
    square = dot3(theta, theta)
    ca, cb, da, db = tangent_coefficients(square)
    # relative angular velocity T thetadot and its rate by thetadot, body components
    spin = about(theta, 1.0 - square * cb, ca, cb, theta_d)
    rate = sum3(cross3(w, spin), tangent_rate(theta, theta_d, cb, da, db))
    if bends:
        rate = sum3(rate, about(theta, 1.0 - square * cb, ca, cb, theta_dd))
    for n in range(3):
        e = (1.0 if n == 0 else 0.0, 1.0 if n == 1 else 0.0, 1.0 if n == 2 else 0.0)
        put_column(J_m, 0, n, e)
        put_column(J_m, 3, n, (0.0, 0.0, 0.0))
        put_column(J_m, 0, 3 + n, turned(A, cross3(e, b)))
        put_column(J_m, 3, 3 + n, column(A, n))
        axis = about(theta, 1.0 - square * ca, 1.0 - square * cb, ca, column(model.marker_A[k], n))
        axis = turned(A, axis)
        motion[AXES + n], motion[AXES + 3 + n], motion[AXES + 6 + n] = axis
    for n in range(m):
        p0 = model.marker_psi[s + n]
        p1 = model.marker_psi[s + m + n]
        p2 = model.marker_psi[s + 2 * m + n]
        slope = (p0, p1, p2)
        if bends:
            slope = sum3(slope, (J_m[3, 6 + n], J_m[4, 6 + n], J_m[5, 6 + n]))
        turn = about(theta, 1.0 - square * cb, ca, cb, slope)
        put_column(J_m, 3, 6 + n, turned(A, turn))
    put(motion, PLACE, sum3(triple(y[i : i + 3]), turned(A, b)))
    wb = cross3(w, b)
    put(motion, VELOCITY, sum3(triple(y[j : j + 3]), turned(A, sum3(wb, b_d))))
    put(motion, SPIN, turned(A, sum3(w, spin)))
    z, x = cross3(w, wb), cross3(w, b_d)
    inward = (
        z[0] + 2.0 * x[0] + b_dd[0],
        z[1] + 2.0 * x[1] + b_dd[1],
        z[2] + 2.0 * x[2] + b_dd[2],
    )
    put(motion, ACCELERATION, turned(A, inward))
    put(motion, SPIN_RATE, turned(A, rate))
