"""Hashin 1980 in three dimensions: separate conditions for fibre and matrix, tension and
compression.

    fibre tension        s11 >= 0:  (s11/Xt)^2 + t = 1
    fibre compression    s11 < 0:   |s11| = Xc
    matrix tension       s >= 0:    (s/Yt)^2 + (s23^2 - s22 s33)/S23^2 + t = 1
    matrix compression   s < 0:     ((Yc/(2 S23))^2 - 1) s/Yc + (s/(2 S23))^2
                                        + (s23^2 - s22 s33)/S23^2 + t = 1

with s = s22 + s33 and the shear along the fibre t = (s12/S12)^2 + (s13/S13)^2
(Z. Hashin, J. Applied Mechanics 47, 1980). The identity s22 s33 = (s^2 - d^2)/4, d = s22 - s33,
removes one square from the last condition.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array
from ...package.common.materials import PlyStrength
from .contract import Criterion, Verdict, exposure, governing

# Shear along the fibre alone has equal terms for fibre and matrix; it is assigned to the matrix.
MODES = ("matrix tension", "matrix compression", "fibre tension", "fibre compression")


class _Condition(NamedTuple):
    """quadratic R^2 + linear R = 1 where `holds`."""

    quadratic: Array
    linear: Array
    holds: NDArray[np.bool_]


def hashin(stress_M: Array, strength: PlyStrength) -> Verdict:
    """Failure of fibre or matrix, whichever comes first.

    Parameters
    ----------
    stress_M : (..., 6) stress in ply axes, order 11, 22, 33, 23, 13, 12 [Pa]
    """
    conditions = _conditions(stress_M, strength)
    exposures = [np.where(c.holds, exposure(c.quadratic, c.linear), 0.0) for c in conditions]
    indices = [np.where(c.holds, c.quadratic + c.linear, 0.0) for c in conditions]
    return governing(MODES, exposures, indices)


def hashin_bound(stress_M: Array, strength: PlyStrength) -> Array:
    """A convex function of the stress, never below the exposure, (...), proportional to it.

    The conditions are used for all signs of the stresses. Each is convex; tension uses only
    the positive part of its stress.
    """
    conditions = _conditions(stress_M, strength, convex=True)
    return np.asarray(np.max([exposure(c.quadratic, c.linear) for c in conditions], axis=0))


def _conditions(
    stress_M: Array, strength: PlyStrength, *, convex: bool = False
) -> list[_Condition]:
    s11, s22, s33, s23, s13, s12 = np.moveaxis(np.asarray(stress_M, dtype=float), -1, 0)
    s, d = s22 + s33, s22 - s33
    pulled = np.maximum(s, 0.0)
    along = (s12 / strength.S12) ** 2 + (s13 / strength.S13) ** 2
    across = (0.25 * d**2 + s23**2) / strength.S23**2
    none = np.zeros_like(s11)
    square = 1.0 / strength.Yt**2 - 0.25 / strength.S23**2
    if convex:
        square = max(square, 0.0)  # negative when S23 < Yt / 2
    push = ((0.5 * strength.Yc / strength.S23) ** 2 - 1.0) / strength.Yc
    fibre = s11 >= 0.0
    matrix = s >= 0.0
    return [
        _Condition(square * pulled**2 + across + along, none, matrix),
        _Condition(across + along, push * s, ~matrix),
        _Condition((np.maximum(s11, 0.0) / strength.Xt) ** 2 + along, none, fibre),
        _Condition(none, np.maximum(-s11, 0.0) / strength.Xc, ~fibre),
    ]


CRITERION = Criterion("hashin", PlyStrength, hashin, convex_bound=hashin_bound, order=4)
