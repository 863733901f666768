"""DKMQ: the discrete Kirchhoff-Mindlin quadrilateral (Katili 1993)."""

from ....solver.math.arrays import Array
from ..plates.strains import side_differences
from ..quadrilaterals import Quadrilaterals
from .contract import QuadPlate
from .strains import QuadStrains, curvature, edge_shear, side_ratio


def dkmq(q: Quadrilaterals, D: Array, Ds: Array) -> QuadStrains:
    """Strains of the discrete Kirchhoff-Mindlin quadrilateral.

    On each side, as for the triangle (plates/dkmt.py),

        gamma_s = -(2/3) phi_k alpha_k,     alpha_k = 3 / (2 L_k (1 + phi_k)) Aw_k u,

    and gamma is the edge interpolation of the four values. phi_k has to be the same number from
    both neighbours of a side; its part of the width (`side_ratio`) and the internal rotations
    (internal.py) let a strip of one cell twist.
    """
    phi = side_ratio(q, D, Ds)
    An = side_differences(q) * (1.5 / (q.length * (1.0 + phi)))[..., None]
    return QuadStrains(curvature(q, An), edge_shear(q, (-2.0 / 3.0 * phi)[..., None] * An))


QUAD = QuadPlate("dkmq", dkmq, internal=True)
