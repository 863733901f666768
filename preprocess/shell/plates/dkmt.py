"""DKMT: the discrete Kirchhoff-Mindlin triangle (Katili 1993)."""

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .contract import Plate
from .strains import PlateStrains, curvature, edge_shear, shear_ratio, side_differences


def dkmt(t: Triangles, D: Array, Ds: Array) -> PlateStrains:
    """Strains of the discrete Kirchhoff-Mindlin triangle.

    On each side the shear strain is that of a beam along it in equilibrium,

        gamma_s = -(2/3) phi_k alpha_k,     phi_k = 12 D_ss / (Ds_ss L_k^2)  (`shear_ratio`),

    so by (side) of `strains`

        alpha_k = 3 / (2 L_k (1 + phi_k)) Aw_k u,

    and gamma is the edge interpolation of the three values. phi -> 0 gives DKT, phi -> infinity
    MITC3.
    """
    phi = shear_ratio(t, D, Ds)
    An = side_differences(t) * (1.5 / (t.length * (1.0 + phi)))[..., None]
    return PlateStrains(curvature(t, An), edge_shear(t, (-2.0 / 3.0 * phi)[..., None] * An))


PLATE = Plate("dkmt", dkmt)
