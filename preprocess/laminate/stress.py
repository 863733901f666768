"""Stress in the plies of a laminate, in the axes of each ply.

A results file stores `stress_operators`: stress = operators @ (N, M, T).
"""

import numpy as np

from ...solver.math.arrays import Array
from ..materials import bond, ply_rotation
from .shear import equilibrium_shear
from .stack import ACROSS, PLANE, Laminate
from .stiffness import laminate_stiffness

LEVELS = ("bottom", "middle", "top")
_HEIGHTS = np.array([0.0, 0.5, 1.0])


def stress_operators(laminate: Laminate) -> Array:
    """Stress of every ply at bottom, middle and top per unit resultant, (k, 3, 6, 8).

    Columns N (3) [Pa/(N/m)], M (3) [Pa/N], T (2) [Pa/(N/m)] in laminate axes; rows 11, 22, 33,
    23, 13, 12 in the axes of the ply. The transverse shear stress follows from equilibrium of
    the plies, not from the constant strain of the theory. It is continuous and zero on the faces.
    """
    stiffness = laminate_stiffness(laminate)
    compliance = np.linalg.inv(stiffness.ABD)
    at = strain_stress(laminate)
    at[..., :6] = at[..., :6] @ compliance
    return at


def strain_stress(laminate: Laminate) -> Array:
    """The same as `stress_operators`, per unit strain e, curvature k and unit T, (k, 3, 6, 8)."""
    return strain_stress_at(laminate, _HEIGHTS)


def strain_stress_at(laminate: Laminate, height: Array) -> Array:
    """Stress in ply axes per unit e [Pa], k [Pa m] and T [1/m], (k, q, 6, 8).

    Parameters
    ----------
    height : (q,) places in every ply, from 0 at its bottom to 1 at its top [-]
    """
    faces = laminate.faces
    z = faces[:-1, None] + np.diff(faces)[:, None] * height
    plane, tau = laminate.plane[:, None], equilibrium_shear(laminate, height)
    stress_E = np.zeros((*z.shape, 6, 8))
    stress_E[..., PLANE, :3] = plane
    stress_E[..., PLANE, 3:6] = z[..., None, None] * plane
    stress_E[..., ACROSS, 6:] = tau
    A_EM = np.array([ply_rotation(ply.angle_deg) for ply in laminate.plies])
    T_ME = bond(np.swapaxes(A_EM, -1, -2))
    return np.asarray(T_ME[:, None] @ stress_E)
