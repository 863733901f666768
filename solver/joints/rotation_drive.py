"""Drive: the rotation of marker two about the common z axis is given in time; one row."""

import numpy as np

from ..bodies.marker import Marker
from ..compiled import jit
from ..rotations import cross
from .rows import Rows, orthogonal_axes

ROWS = "r"


@jit
def rotation_drive(
    rows: Rows, k: int, one: Marker, two: Marker, f: float, f_d: float, f_dd: float
) -> None:
    """Row k: sin(angle - f) = 0 with f and its rates of time [rad, rad/s, rad/s2].

    The axis a of marker one, turned by f + 90 deg about z, stays orthogonal to
    x of marker two: smooth for any number of turns, no branch of an arc tangent.
    """
    z = one.A[:, 2].copy()
    a = one.A[:, 1] * np.cos(f) - one.A[:, 0] * np.sin(f)
    orthogonal_axes(
        rows, k, one, two, a, two.A[:, 0].copy(), f_d * z, f_dd * z + f_d * cross(one.w, z)
    )
