"""Which strains a beam may have: the full six, or the classical four without shear."""

import numpy as np

from ...solver.math.arrays import Array

_REMAINING_SHEAR = 1e-4  # per row and column: 1e-8 of the shear compliance is as good as none


def section_stiffness(K: Array, theory: str) -> Array:
    """Return the 6x6 stiffness that a beam of this theory uses.

    "timoshenko" takes K as it is. "classical" takes the shear compliance out, coupled
    entries included; extension, twist and bending keep theirs, inertia is not touched.

    The shear stiffness of a 6x6 comes from the energy of a constant shear force. In a wide
    strip whose bending and twist are coupled it also holds the energy of a changing twist,
    and vibration, in which the shear force changes along the beam, meets too soft a strip:
    there the classical theory is nearer to a solid (tests/fe/test_beam_solid.py).
    """
    if theory == "timoshenko":
        return K
    S = np.linalg.inv(K)
    S[1:3, :] *= _REMAINING_SHEAR
    S[:, 1:3] *= _REMAINING_SHEAR
    stiffness = np.linalg.inv(S)
    return 0.5 * (stiffness + stiffness.T)
