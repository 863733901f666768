"""Maximum stress: every component is compared with its own strength."""

import numpy as np

from ...math.arrays import Array
from ...package.common.materials import PlyStrength
from .contract import Criterion, Verdict

NORMAL = ("11", "22", "33")
SHEAR = ("23", "13", "12")
MODES = (
    *(f"{name} {sign}" for name in NORMAL for sign in ("tension", "compression")),
    *(f"{name} shear" for name in SHEAR),
)


def exhausted(stress_M: Array, strength: PlyStrength) -> Array:
    """Each stress over its strength, (9, ...) in the order of MODES; negative for the other
    sign."""
    s = np.moveaxis(np.asarray(stress_M, dtype=float), -1, 0)
    used = np.empty((len(MODES), *s.shape[1:]))  # the largest of a row of nine takes long
    tension = strength.Xt, strength.Yt, strength.Zt
    compression = strength.Xc, strength.Yc, strength.Zc
    shear = strength.S23, strength.S13, strength.S12
    for k in range(3):
        used[2 * k], used[2 * k + 1] = s[k] / tension[k], -s[k] / compression[k]
        used[6 + k] = np.abs(s[3 + k]) / shear[k]
    return used


def max_stress(stress_M: Array, strength: PlyStrength) -> Verdict:
    """Failure if one stress reaches its strength; the index is linear in the stress.

    Parameters
    ----------
    stress_M : (..., 6) stress in ply axes, order 11, 22, 33, 23, 13, 12 [Pa]
    """
    used = exhausted(stress_M, strength)
    highest = np.asarray(used.max(axis=0))
    return Verdict(highest, highest, np.moveaxis(used, 0, -1), MODES)


CRITERION = Criterion("max-stress", PlyStrength, max_stress, order=1)
