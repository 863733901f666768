"""The motion of one marker as a row of numbers, with functions for its parts.

In compiled code a row is one argument: joints and force elements are called with two rows. Here are
also the numbers of a row of a force element, and the second-order terms of markers.
"""

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array, Triple
from ...math.compiled import inlined, lean

PLACE, AXES, VELOCITY, SPIN, ACCELERATION, SPIN_RATE = 0, 3, 12, 15, 18, 21
N_MOTION = 24
# A row of a force element (forces/contract.py): coefficients C of v_1, w_1, v_2, w_2, then these.
STIFFNESS, DAMPING, FORCE = 12, 13, 14
N_ELEMENT_ROW = 15


@inlined
def place(m: Array) -> Triple:
    """Position x_G [m]."""
    return m[0], m[1], m[2]


@inlined
def axis(m: Array, i: int) -> Triple:
    """Axis i of the marker, global components: column i of A_GM."""
    return m[3 + i], m[6 + i], m[9 + i]


@inlined
def in_axes(m: Array, a: Triple) -> Triple:
    """A_GM' a: components of a global vector in the marker's axes."""
    return (
        m[3] * a[0] + m[6] * a[1] + m[9] * a[2],
        m[4] * a[0] + m[7] * a[1] + m[10] * a[2],
        m[5] * a[0] + m[8] * a[1] + m[11] * a[2],
    )


@inlined
def from_axes(m: Array, a: Triple) -> Triple:
    """A_GM a: global components of a vector in the marker's axes."""
    return (
        m[3] * a[0] + m[4] * a[1] + m[5] * a[2],
        m[6] * a[0] + m[7] * a[1] + m[8] * a[2],
        m[9] * a[0] + m[10] * a[1] + m[11] * a[2],
    )


@inlined
def velocity(m: Array) -> Triple:
    """Velocity [m/s]."""
    return m[12], m[13], m[14]


@inlined
def spin(m: Array) -> Triple:
    """Angular velocity, global components [rad/s]."""
    return m[15], m[16], m[17]


@inlined
def acceleration(m: Array) -> Triple:
    """Acceleration at zero coordinate accelerations [m/s2]."""
    return m[18], m[19], m[20]


@inlined
def spin_rate(m: Array) -> Triple:
    """Rate of the angular velocity at zero coordinate accelerations [rad/s2]."""
    return m[21], m[22], m[23]


@inlined
def put(m: Array, part: int, a: Triple) -> None:
    """Write a into three numbers of the row, from `part` on.

    Parameters
    ----------
    m : motion of a marker (24,)
    part : place of the first number
    a : the three numbers
    """
    m[part], m[part + 1], m[part + 2] = a[0], a[1], a[2]


@lean
def stand(motion: Array, x: Array, A: Array) -> None:
    """Fill the motion of a marker of the ground at x (3,) with axes A (3, 3).

    Parameters
    ----------
    motion : motion of a marker (24,), to fill
    x : position (3,), global [m]
    A : axes (3, 3)
    """
    for i in range(3):
        motion[PLACE + i] = x[i]
        for j in range(3):
            motion[AXES + 3 * i + j] = A[i, j]


@lean
def contract(T: Array, start: int, q: Array, q_d: Array, slope: Array) -> Triple:
    """Contract a table symmetric in two modes: return q T q, q T q_d, q_d T q_d.

    Parameters
    ----------
    T : flat, the table (m, m) from `start` on
    q, q_d : (m,)
    slope : (m,) gets T q added
    """
    by_q, mixed, by_q_d = 0.0, 0.0, 0.0
    row = start
    for i in range(q.shape[0]):
        one, two = 0.0, 0.0
        for j in range(q.shape[0]):
            one += T[row + j] * q[j]
            two += T[row + j] * q_d[j]
        row += q.shape[0]
        slope[i] += one
        by_q += one * q[i]
        mixed += one * q_d[i]
        by_q_d += two * q_d[i]
    return by_q, mixed, by_q_d


@inlined
def bend_marker(
    H: Array, start: int, used: NDArray[np.int8], row: int, q: Array, q_d: Array, J_m: Array
) -> tuple[Triple, Triple, Triple]:
    """Return the second-order terms of a vector of a marker and of its rates.

    1/2 q' H q, q' H q_d and q_d' H q_d of the translation (`row` 0) or of the rotation vector
    (`row` 3), body components. The columns of the modes in J_m (6, n) become H q there.

    Parameters
    ----------
    H : flat, the six tables (m, m) of the marker from `start` on
    used : (6,) which of them are not zero
    """
    m = q.shape[0]
    h = start + row * m * m
    x = y = z = (0.0, 0.0, 0.0)
    for a in range(row, row + 3):
        for n in range(6, 6 + m):
            J_m[a, n] = 0.0
    if used[row]:
        x = contract(H, h, q, q_d, J_m[row, 6 : 6 + m])
    if used[row + 1]:
        y = contract(H, h + m * m, q, q_d, J_m[row + 1, 6 : 6 + m])
    if used[row + 2]:
        z = contract(H, h + 2 * m * m, q, q_d, J_m[row + 2, 6 : 6 + m])
    return (
        (0.5 * x[0], 0.5 * y[0], 0.5 * z[0]),
        (x[1], y[1], z[1]),
        (x[2], y[2], z[2]),
    )
