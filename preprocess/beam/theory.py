"""Beam theories: Timoshenko with six strains, or the classical theory without shear."""

from dataclasses import replace

import numpy as np

from ...solver.math.arrays import Array
from .line import LineSection

_REMAINING_SHEAR = 1e-4  # per row and column: 1e-8 of the shear compliance is negligible


def of_theory(section: LineSection, theory: str) -> LineSection:
    """The section as a beam of this theory uses it."""
    if theory == "timoshenko":
        return section
    trapeze = section.trapeze.copy()
    trapeze[1:3] = 0.0
    return replace(section, K=section_stiffness(section.K, theory), trapeze=trapeze)


def section_stiffness(K: Array, theory: str) -> Array:
    """Return the 6x6 stiffness that a beam of this theory uses.

    "timoshenko" uses K unchanged. "classical" removes the shear compliance with its coupled
    entries. Extension, twist and bending keep their compliance; inertia does not change.

    The shear stiffness of a 6x6 follows from the energy of a constant shear force. In a wide
    strip with coupled bending and twist it also includes the energy of a changing twist. In
    vibration the shear force changes along the beam, and such a strip is then too soft.
    The classical theory is closer to a solid there (tests/fe/test_beam_solid.py).
    """
    if theory == "timoshenko":
        return K
    S = np.linalg.inv(K)
    S[1:3, :] *= _REMAINING_SHEAR
    S[:, 1:3] *= _REMAINING_SHEAR
    stiffness = np.linalg.inv(S)
    return 0.5 * (stiffness + stiffness.T)
