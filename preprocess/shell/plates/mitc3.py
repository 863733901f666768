"""MITC3: linear rotations, shear strain tied on the sides."""

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .contract import Plate
from .strains import PlateStrains, curvature, edge_shear, side_differences


def mitc3(t: Triangles, D: Array, Ds: Array) -> PlateStrains:
    """Strains of the triangle with mixed interpolation of tensorial components.

    The rotations are linear, alpha = 0, so the curvature is constant; the shear strain is the
    edge interpolation of its mean on each side, gamma_k = -Aw_k u / L_k by (side) of `strains`.
    """
    side = side_differences(t) * (-1.0 / t.length)[..., None]
    return PlateStrains(curvature(t, None), edge_shear(t, side))


PLATE = Plate("mitc3", mitc3)
