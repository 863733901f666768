"""Tsai-Hill: Hill's quadratic form; each strength depends on the sign of its stress.

(s11/X)^2 + (s22/Y)^2 + (s33/Z)^2 + (s23/S23)^2 + (s13/S13)^2 + (s12/S12)^2
    - 2H s11 s22 - 2G s11 s33 - 2F s22 s33 = 1,
2H = 1/X^2 + 1/Y^2 - 1/Z^2,  2G = 1/X^2 + 1/Z^2 - 1/Y^2,  2F = 1/Y^2 + 1/Z^2 - 1/X^2

In 2H and 2G, the strength of the third direction has the sign of the
transverse stress, and in 2F X is that of tension. The left-hand side is then continuous where a
stress changes its sign. With Y = Z it is the textbook form s11^2/X^2 - s11 s22/X^2 + s22^2/Y^2 +
s12^2/S12^2 in plane stress (Azzi and Tsai, Experimental Mechanics 5, 1965).
"""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array
from ...package.common.materials import PlyStrength
from .contract import Criterion, Verdict
from .max_stress import exhausted

MODES = ("fibre", "matrix", "through thickness", "23 shear", "13 shear", "12 shear")


def tsai_hill(stress_M: Array, strength: PlyStrength) -> Verdict:
    """Failure on Hill's surface; the mode is the stress with the largest square term.

    Parameters
    ----------
    stress_M : (..., 6) stress in ply axes, order 11, 22, 33, 23, 13, 12 [Pa]
    """
    s = np.asarray(stress_M, dtype=float)
    squares = _normalised(s, strength) ** 2  # (6, ...)
    tension = s[..., :3] >= 0.0
    H2, G2, F2 = _pairs(tension, strength)
    s1, s2, s3 = (s[..., i] for i in range(3))
    index = squares.sum(axis=0) - H2 * s1 * s2 - G2 * s1 * s3 - F2 * s2 * s3
    index = np.maximum(index, 0.0)  # in Hill's theory a hydrostatic stress causes no failure
    return Verdict(np.sqrt(index), index, np.moveaxis(squares, 0, -1), MODES)


def tsai_hill_bound(stress_M: Array, strength: PlyStrength) -> Array:
    """A convex function of the stress, never below the exposure, (...), proportional to it."""
    u = _normalised(np.asarray(stress_M, dtype=float), strength)
    return np.asarray(np.sqrt(np.moveaxis(u * u, 0, -1) @ _weights(strength)))


def _normalised(s: Array, strength: PlyStrength) -> Array:
    """Stresses over their strengths, (6, ...)."""
    used = exhausted(s, strength)
    used[:3] = np.maximum(used[0:6:2], used[1:6:2])
    used[3:6] = used[6:]
    return used[:6]


def _pairs(tension: NDArray[np.bool_], strength: PlyStrength) -> tuple[Array, Array, Array]:
    """2H, 2G, 2F for the signs of the three normal stresses, (..., 3) true in tension."""

    def inverse_square(t: float, c: float, sign: int) -> Array:
        return np.where(tension[..., sign], 1.0 / t**2, 1.0 / c**2)

    Xt, Xc, Yt, Yc = strength.Xt, strength.Xc, strength.Yt, strength.Yc
    Zt, Zc = strength.Zt, strength.Zc
    X = inverse_square(Xt, Xc, 0)
    Y, Z_of_2 = inverse_square(Yt, Yc, 1), inverse_square(Zt, Zc, 1)
    Z, Y_of_3 = inverse_square(Zt, Zc, 2), inverse_square(Yt, Yc, 2)
    return X + Y - Z_of_2, X + Z - Y_of_3, Y + Z - 1.0 / Xt**2


def _weights(strength: PlyStrength) -> Array:
    """Weights w with sum w_i u_i^2 >= index for all signs, u the normalised stresses, (6,).

    By 2 u_i u_j <= u_i^2 + u_j^2, a positive product is divided between its two stresses.
    """
    w = np.ones(6)
    limits = ((strength.Xc, strength.Xt), (strength.Yc, strength.Yt), (strength.Zc, strength.Zt))
    worst = {(0, 1): 0.0, (0, 2): 0.0, (1, 2): 0.0}
    for signs in product((0, 1), repeat=3):
        tension = np.array(signs, dtype=bool)
        for (i, j), pair in zip(worst, _pairs(tension, strength), strict=True):
            size = limits[i][signs[i]] * limits[j][signs[j]]
            added = -float(pair) * size * (1.0 if signs[i] == signs[j] else -1.0)
            worst[i, j] = max(worst[i, j], added)
    for (i, j), added in worst.items():
        w[[i, j]] += 0.5 * added
    return w


CRITERION = Criterion("tsai-hill", PlyStrength, tsai_hill, convex_bound=tsai_hill_bound, order=2)
