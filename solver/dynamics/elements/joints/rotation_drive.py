"""Drive: the rotation of marker two about the common z axis is given in time; one row."""

import numpy as np

from ....math.arrays import Array
from ....math.compiled import jit
from ....math.rotations import cross3, minus3, sum3, times3
from ...model.motion import axis, spin
from .contract import ANGLE, Drive
from .rows import orthogonal_axes


@jit
def rotation_drive(
    rows: Array, k: int, one: Array, two: Array, f: float, f_d: float, f_dd: float
) -> None:
    """Row k: sin(angle - f) = 0 with f and its rates of time [rad, rad/s, rad/s2].

    The axis a of marker one, turned by f + 90 deg about z, stays orthogonal to
    x of marker two: smooth for any number of turns, no branch of an arc tangent.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    f : angle [rad]
    f_d : its rate [rad/s]
    f_dd : its second rate [rad/s2]
    """
    z, y, x = axis(one, 2), axis(one, 1), axis(one, 0)
    a = minus3(times3(np.cos(f), y), times3(np.sin(f), x))
    turning = cross3(spin(one), z)
    turning_rate = sum3(times3(f_dd, z), times3(f_d, turning))
    orthogonal_axes(rows, k, one, two, a, axis(two, 0), times3(f_d, z), turning_rate)


def cosine(A_1: Array, A_2: Array, f: float) -> float:
    """Return cos(angle - f): 1 at the wanted angle, -1 half a turn away, where the row is 0 too.

    Parameters
    ----------
    A_1 : axes of marker one (3, 3)
    A_2 : axes of marker two (3, 3)
    f : angle of the drive [rad]
    """
    wanted = A_1[:, 0] * np.cos(f) + A_1[:, 1] * np.sin(f)
    return float(wanted @ A_2[:, 0])


ROTATION_DRIVE = Drive(
    kind="rotation_drive",
    rows=rotation_drive,
    units="r",
    removes=("about z",),
    coordinate=ANGLE,
    side=cosine,
)
