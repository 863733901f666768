"""MITC3: linear rotations, shear strain tied on the sides."""

from ..cell import Cell
from .contract import Plate, PlateStrains, curvature, edge_shear, side_differences


def mitc3(t: Cell) -> PlateStrains:
    """Strains of the triangle with mixed interpolation of tensorial components; also of MITC4.

    The rotations are those of the corners, alpha = 0; the shear strain is the edge interpolation
    of its mean on each side, gamma_k = -Aw_k / L_k by (side) of contract.py.
    """
    Aw = side_differences(t)
    gamma = [-Aw[k] / t.length[k] for k in range(t.k)]
    return PlateStrains(curvature(t, None), edge_shear(t, gamma))


PLATE = Plate("mitc3", mitc3)
