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
    """Each stress over its strength, (..., 9) in the order of MODES; negative for the other
    sign."""
    s = np.asarray(stress_M, dtype=float)
    tension = s[..., :3] / [strength.Xt, strength.Yt, strength.Zt]
    compression = -s[..., :3] / [strength.Xc, strength.Yc, strength.Zc]
    shear = np.abs(s[..., 3:]) / [strength.S23, strength.S13, strength.S12]
    normal = np.stack([tension, compression], axis=-1).reshape(*s.shape[:-1], 6)
    return np.concatenate([normal, shear], axis=-1)


def max_stress(stress_M: Array, strength: PlyStrength) -> Verdict:
    """Failure if one stress reaches its strength; the index is linear in the stress.

    Parameters
    ----------
    stress_M : (..., 6) stress in ply axes, order 11, 22, 33, 23, 13, 12 [Pa]
    """
    used = exhausted(stress_M, strength)
    highest = used.max(axis=-1)
    return Verdict(highest, highest, np.argmax(used, axis=-1), MODES)


CRITERION = Criterion("max-stress", PlyStrength, max_stress, order=1)
