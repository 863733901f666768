"""The motion of one marker as a row of numbers, with functions for its parts.

In compiled code a row is one argument: joints and force elements are called with two rows.
"""

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ...math.rotations import Triple

PLACE, AXES, VELOCITY, SPIN, ACCELERATION, SPIN_RATE = 0, 3, 12, 15, 18, 21
N_MOTION = 24


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
    """Write a into three numbers of the row, from `part` on."""
    m[part], m[part + 1], m[part + 2] = a[0], a[1], a[2]


@lean
def stand(motion: Array, x: Array, A: Array) -> None:
    """Fill the motion of a marker of the ground at x (3,) with axes A (3, 3)."""
    for i in range(3):
        motion[PLACE + i] = x[i]
        for j in range(3):
            motion[AXES + 3 * i + j] = A[i, j]
