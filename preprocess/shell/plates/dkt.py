"""DKT: the discrete Kirchhoff triangle, without transverse shear."""

import numpy as np

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .contract import Plate
from .strains import PlateStrains, curvature, side_differences


def dkt(t: Triangles, D: Array, Ds: Array) -> PlateStrains:
    """Strains of the discrete Kirchhoff triangle.

    On each side gamma_s = 0, so by (side) of `strains`

        alpha_k = 3 / (2 L_k) Aw_k u,

    and there is no shear energy.
    """
    An = side_differences(t) * (1.5 / t.length)[..., None]
    return PlateStrains(curvature(t, An), np.empty((len(t), 0, 2, 9)))


PLATE = Plate("dkt", dkt)
