"""Plies in plane stress: harmonics of their angle, and integrals over their thickness.

Q(a) = mean + sum over h of factors_h t_h(a) PATTERNS_h, t = (cos 2a, sin 2a, cos 4a, sin 4a).
"""

from collections.abc import Sequence

import numpy as np

from ...math.arrays import Array
from ..common.materials import Orthotropic

PLANE = np.array([0, 1, 5])  # 11, 22, 12 of a stress column 11 22 33 23 13 12
PATTERNS = np.array(  # of the plane stiffness of a ply, by harmonic
    [
        [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.5], [0.0, 0.0, 0.5], [0.5, 0.5, 0.0]],
        [[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
        [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, -1.0, 0.0]],
    ]
)


def harmonics(angles_deg: Array) -> Array:
    """cos 2a, sin 2a, cos 4a, sin 4a of angles (...), (..., 4)."""
    a = np.radians(2.0 * angles_deg)
    return np.stack([np.cos(a), np.sin(a), np.cos(2.0 * a), np.sin(2.0 * a)], axis=-1)


def ply_factors(materials: Sequence[Orthotropic]) -> tuple[Array, Array]:
    """Mean (k, 3, 3) over all angles, and factors (k, 4) of the patterns, of plies [Pa]."""
    Q = np.linalg.inv([each.compliance_M[PLANE[:, None], PLANE] for each in materials])
    Q11, Q22, Q12, Q66 = Q[:, 0, 0], Q[:, 1, 1], Q[:, 0, 1], Q[:, 2, 2]
    U2, U3 = 0.5 * (Q11 - Q22), 0.125 * (Q11 + Q22 - 2.0 * Q12 - 4.0 * Q66)
    factors = np.stack([U2, U2, U3, U3], axis=1)
    return Q - np.einsum("kh,hij->kij", factors[:, ::2], PATTERNS[::2]), factors


def faces(thicknesses: Sequence[float] | Array, offset: float = 0.0) -> Array:
    """Height z of the faces of plies from the bottom up, (k + 1,) [m]; `offset` of the middle."""
    # measured from the middle, so that symmetric plies are symmetric to the last digit
    up = np.cumsum([0.0, *thicknesses])
    down = np.cumsum([0.0, *thicknesses[::-1]])[::-1]
    return np.asarray(0.5 * (up - down) + offset)


def moments(thicknesses: Sequence[float] | Array, offset: float = 0.0) -> Array:
    """H_1, H_2, H_3 of plies: integrals of 1, z, z^2 over each, (3, k) [m, m2, m3].

    Paper: Eq. (30), with the limits h_l and h_(l+1) of its right side.
    """
    thickness, z = np.asarray(thicknesses), faces(thicknesses, offset)
    middle = 0.5 * (z[1:] + z[:-1])
    # equal to (h_(l+1)^n - h_l^n) / n, without the difference of nearly equal numbers
    return np.stack([thickness, thickness * middle, thickness * (middle**2 + thickness**2 / 12.0)])
