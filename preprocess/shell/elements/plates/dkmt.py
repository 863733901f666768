"""DKMT: the discrete Kirchhoff-Mindlin triangle (Katili 1993)."""

from ..cell import Cell
from .contract import Plate, PlateStrains, curvature, edge_shear, side_differences, side_ratios


def dkmt(t: Cell) -> PlateStrains:
    """Strains of the discrete Kirchhoff-Mindlin triangle, and of the quadrilateral DKMQ.

    On each side the shear strain is that of a beam along it in equilibrium,

        gamma_s = -(2/3) phi_k alpha_k,     phi_k = 12 D_ss / (Ds_ss L_k^2)  (`shear_ratio`),

    so by (side) of contract.py

        alpha_k = 3 / (2 L_k (1 + phi_k)) Aw_k,

    and gamma is the edge interpolation of these values. phi -> 0 gives DKT, phi -> infinity
    MITC3. phi_k has to be the same number from both neighbours of a side.
    """
    Aw, phi = side_differences(t), side_ratios(t)
    alpha = [1.5 * Aw[k] / (t.length[k] * (1.0 + phi[k])) for k in range(t.k)]
    gamma = [-2.0 / 3.0 * phi[k] * alpha[k] for k in range(t.k)]
    return PlateStrains(curvature(t, alpha), edge_shear(t, gamma))


PLATE = Plate("dkmt", dkmt)
