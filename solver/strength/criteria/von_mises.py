"""Von Mises: yield of an isotropic material."""

import numpy as np

from ...math.arrays import Array
from ...package.common.materials import YieldStrength
from .contract import Criterion, Verdict

MODES = ("yield",)


def equivalent_stress(stress: Array) -> Array:
    """Von Mises' equivalent stress, (...) [Pa], of stresses (..., 6) in any axes."""
    s = np.asarray(stress, dtype=float)
    s1, s2, s3 = (s[..., i] for i in range(3))
    shear = np.sum(s[..., 3:] ** 2, axis=-1)
    square = 0.5 * ((s1 - s2) ** 2 + (s2 - s3) ** 2 + (s3 - s1) ** 2) + 3.0 * shear
    return np.asarray(np.sqrt(square))


def von_mises(stress: Array, strength: YieldStrength) -> Verdict:
    """Yield if the equivalent stress reaches the yield stress; the index is linear in it.

    Parameters
    ----------
    stress : (..., 6) order 11, 22, 33, 23, 13, 12 [Pa]
    """
    used = equivalent_stress(stress) / strength.yield_stress
    return Verdict(used, used, used[..., None], MODES)


CRITERION = Criterion("von-mises", YieldStrength, von_mises, order=1)
