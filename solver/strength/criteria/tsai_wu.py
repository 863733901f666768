"""Tsai-Wu: one closed quadratic surface through all uniaxial strengths.

F_i s_i + F_ij s_i s_j = 1 with F_1 = 1/Xt - 1/Xc, F_11 = 1/(Xt Xc), F_44 = 1/S23^2, ...
and F_ij = F12_star sqrt(F_ii F_jj) for each pair of normal stresses
(Tsai and Wu, J. Composite Materials 5, 1971).
"""

import numpy as np

from ...math.arrays import Array
from ...package.common.materials import PlyStrength
from .contract import Criterion, Verdict, exposure

MODES = ("fibre", "matrix", "through thickness", "23 shear", "13 shear", "12 shear")


def coefficients(strength: PlyStrength) -> tuple[Array, Array]:
    """F_i, (6,) [1/Pa], and F_ij, (6, 6) [1/Pa2]."""
    tension = np.array([strength.Xt, strength.Yt, strength.Zt])
    compression = np.array([strength.Xc, strength.Yc, strength.Zc])
    shear = np.array([strength.S23, strength.S13, strength.S12])
    linear = np.concatenate([1.0 / tension - 1.0 / compression, np.zeros(3)])
    diagonal = np.concatenate([1.0 / (tension * compression), 1.0 / shear**2])
    quadratic = np.diag(diagonal)
    root = np.sqrt(diagonal[:3])
    pairs = ~np.eye(3, dtype=bool)
    quadratic[:3, :3][pairs] = strength.F12_star * np.outer(root, root)[pairs]
    return linear, quadratic


def tsai_wu(stress_M: Array, strength: PlyStrength) -> Verdict:
    """Failure on the quadratic surface; the mode is the stress with the largest share of it.

    Parameters
    ----------
    stress_M : (..., 6) stress in ply axes, order 11, 22, 33, 23, 13, 12 [Pa]
    """
    s = np.asarray(stress_M, dtype=float)
    F_i, F_ij = coefficients(strength)
    force = s @ F_ij
    a, b = np.einsum("...i,...i->...", s, force), s @ F_i
    # With F12_star = -0.5 the surface is open in one of three directions, where a is zero.
    a = np.maximum(a, 0.0)
    exposures = exposure(a, b)
    # Share of each stress in a + b once the stress is scaled to failure.
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = s * force / exposures[..., None] + s * F_i
    return Verdict(exposures, a + b, shares, MODES)


CRITERION = Criterion("tsai-wu", PlyStrength, tsai_wu, order=3)
