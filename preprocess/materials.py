"""Rotation of elastic materials: from material axes to those of the member.

The constants and their bounds are in `plymotion.solver.package.materials`, where
the case checker finds them too. Stress and strain are columns in the paper's
order 11, 22, 33, 23, 13, 12 with engineering shear strains. `_M` are the axes of
the material (1 along the fibre, 3 normal to the ply), `_B` those of the member.
"""

import math

import numpy as np

from plymotion.solver.package.materials import (
    MaterialError,
    Orthotropic,
    isotropic,
    material_from_dict,
)
from plymotion.solver.package.schema import Array

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

    The fibre lies at cos(angle) e1 + sin(angle) e2, turned right-handed about the outward
    normal e3 of the wall.
    """
    angle = math.radians(ply_angle_deg)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def bond(A_BM: Array) -> Array:
    """Matrix T (6, 6) that takes stress columns along: stress_B = T stress_M (Bond 1943)."""
    pairs = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    T = np.empty((6, 6))
    for row, (i, j) in enumerate(pairs):
        for column, (k, m) in enumerate(pairs):
            T[row, column] = A_BM[i, k] * A_BM[j, m]
            if k != m:  # a shear stress stands for two entries of the tensor
                T[row, column] += A_BM[i, m] * A_BM[j, k]
    return T


def rotated(C_M: Array, A_BM: Array) -> Array:
    """Stiffness in the axes of the member: C_B = T C_M T', (6, 6) [Pa].

    Paper: Eq. (18), Eq. (19).

    Parameters
    ----------
    C_M : (6, 6) stiffness in material axes [Pa]
    A_BM : (3, 3) rotation, v_B = A_BM v_M
    """
    T = bond(A_BM)
    C = T @ C_M @ T.T
    return 0.5 * (C + C.T)
