"""Rotation of elastic materials: from material axes to those of the member.

Constants, bounds and the Bond matrix are in `plymotion.solver.package.common.materials`, because
the solver uses them too. Stress and strain are columns in the paper's
order 11, 22, 33, 23, 13, 12 with engineering shear strains. `_M` are the axes of
the material (1 along the fibre, 3 normal to the ply), `_B` those of the member.
"""

import math

import numpy as np

from plymotion.solver.math.arrays import Array
from plymotion.solver.package.common.materials import (
    MaterialError,
    Orthotropic,
    bond,
    isotropic,
    material_from_dict,
)

__all__ = [
    "MaterialError",
    "Orthotropic",
    "bond",
    "isotropic",
    "material_from_dict",
    "ply_rotation",
    "rotated",
]


def ply_rotation(ply_angle_deg: float) -> Array:
    """Axes of a ply in those of its wall: A_BM (3, 3), v_B = A_BM v_M.

    The fibre direction is cos(angle) e1 + sin(angle) e2, right-handed about the outward
    normal e3 of the wall.
    """
    angle = math.radians(ply_angle_deg)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def rotated(C_M: Array, A_BM: Array) -> Array:
    """Stiffness in the axes of the member: C_B = T C_M T', (..., 6, 6) [Pa].

    Paper: Eq. (18), Eq. (19).

    Parameters
    ----------
    C_M : (..., 6, 6) stiffness in material axes [Pa]
    A_BM : (..., 3, 3) rotation, v_B = A_BM v_M
    """
    T = bond(A_BM)
    C = T @ C_M @ np.swapaxes(T, -1, -2)
    return np.asarray(0.5 * (C + np.swapaxes(C, -1, -2)))
