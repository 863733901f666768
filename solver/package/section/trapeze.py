"""Trapeze effect: a twisted section shortens and, if it is not symmetric, bends.

The fibres of a section that twists by k1 per length become helices about its shear centre. A fibre
at the distance r has the second-order strain 1/2 r^2 k1^2 along the beam. Without resultants the
section then takes the strains e6 = -1/2 a k1^2. With the axial stress s11_j of a unit resultant j,
its warping included, reciprocity gives

    a_j = int r^2 s11_j dA,   order extension, shear2, shear3, twist, bend2, bend3.

Of one material a_1 is the polar radius of gyration squared, (b^2 + t^2) / 12 of a rectangle. Under
the tension N the section resists torsion with N a_1 besides its stiffness.
"""

import numpy as np

from ...math.arrays import Array
from .schema import SectionRecovery
from .stress import unit_stress


def trapeze_strains(K: Array, recovery: SectionRecovery) -> Array:
    """Strains a (6,) of a section twisted by 1 rad/m, times -2: (m2, m2, m2, m, m, m).

    Parameters
    ----------
    K : (6, 6) section stiffness, which determines the shear centre
    recovery : stresses of the section per unit resultant
    """
    S = np.linalg.inv(K)
    # u2 = x3c f1 and u3 = -x2c f1 of the reference line, when the shear centre stays in place
    x2, x3 = -S[2, 3] / S[3, 3], S[1, 3] / S[3, 3]
    r2 = (recovery.points[:, 0] - x2) ** 2 + (recovery.points[:, 1] - x3) ** 2
    return np.asarray((recovery.weights * r2) @ unit_stress(recovery)[:, 0])
