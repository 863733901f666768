"""MITC4: bilinear rotations, shear strain tied on the sides (Bathe and Dvorkin 1985)."""

from ....solver.math.arrays import Array
from ..plates.strains import side_differences
from ..quadrilaterals import Quadrilaterals
from .contract import QuadPlate
from .strains import QuadStrains, curvature, edge_shear


def mitc4(q: Quadrilaterals, D: Array, Ds: Array) -> QuadStrains:
    """Strains of the quadrilateral with mixed interpolation of tensorial components.

    The rotations are bilinear, alpha = 0; the shear strain is the edge interpolation of its mean
    on each side, gamma_k = -Aw_k u / L_k by (side) of strains.py.
    """
    side = side_differences(q) * (-1.0 / q.length)[..., None]
    return QuadStrains(curvature(q, None), edge_shear(q, side))


QUAD = QuadPlate("mitc4", mitc4)
