"""DKT: the discrete Kirchhoff triangle, without transverse shear."""

from ..cell import Cell
from .contract import Plate, PlateStrains, curvature, side_differences


def dkt(t: Cell) -> PlateStrains:
    """Strains of the discrete Kirchhoff triangle.

    On each side gamma_s = 0, so by (side) of contract.py

        alpha_k = 3 / (2 L_k) Aw_k,

    and there is no shear energy.
    """
    Aw = side_differences(t)
    return PlateStrains(curvature(t, [1.5 * Aw[k] / t.length[k] for k in range(t.k)]), [])


PLATE = Plate("dkt", dkt)
