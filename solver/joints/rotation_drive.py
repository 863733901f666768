"""Drive: the rotation of marker two about the common z axis is given in time; one row."""

import numpy as np

from ..bodies.marker import Marker
from ..compiled import jit
from ..package.schema import Array
from ..rotations import cross
from .rows import Rows, orthogonal_axes

N_ROW = 1


@jit
def polynomial(coefficients: Array, t: float) -> tuple[float, float, float]:
    """Return value, first and second derivative of sum c_i t^i at t."""
    f, f_d, f_dd = 0.0, 0.0, 0.0
    for c in coefficients[::-1]:
        f_dd = f_dd * t + 2.0 * f_d
        f_d = f_d * t + f
        f = f * t + c
    return f, f_d, f_dd


@jit
def rotation_drive(
    rows: Rows, k: int, one: Marker, two: Marker, t: float, coefficients: Array
) -> None:
    """Row k: sin(angle - f(t)) = 0 with f a polynomial of time [rad].

    The axis a of marker one, turned by f + 90 deg about z, stays orthogonal to
    x of marker two: smooth for any number of turns, no branch of an arc tangent.
    """
    f, f_d, f_dd = polynomial(coefficients, t)
    z = one.A[:, 2].copy()
    a = one.A[:, 1] * np.cos(f) - one.A[:, 0] * np.sin(f)
    orthogonal_axes(
        rows, k, one, two, a, two.A[:, 0].copy(), f_d * z, f_dd * z + f_d * cross(one.w, z)
    )
