"""Allman's triangle: quadratic displacements driven by the rotations of the corners."""

import numpy as np

from ....solver.math.arrays import Array
from ..drilling.excess import excess_rotation
from ..sides import bulge_slopes
from ..triangles import END, START, Triangles
from .contract import Membrane
from .strains import MembraneStrains, linear_strain

# Relative to A66, stiffness of equal rotations of all corners. It affects warped shells: with a
# hundredth of this value a twisted beam becomes too soft with refinement, by a tenth at 8 cells
# across.
SPURIOUS = 0.1


def allman(t: Triangles, A: Array, beta0: float | str) -> MembraneStrains:
    """Strains of the triangle of Allman.

    The middle of a side is displaced from its chord in the direction n_k = (t_y, -t_x) by
    (L_k/8)(tz_j - tz_i):

        (u, v) = sum_i l_i (u, v)_i + sum_k P_k (L_k/8)(tz_j - tz_i) n_k,   P_k = 4 l_i l_j,

    whose strain is linear. Equal tz at all corners cause no displacement; the extra stiffness
    0.1 A66 area m^2 with m = mean(tz) - (v,x - u,y)/2 acts on them.
    """
    c = len(t)
    slope = bulge_slopes(t)
    x, y = t.length * t.tangent[..., 1] / 8.0, t.length * t.tangent[..., 0] / -8.0
    bulge = np.empty((c, 3, 3, 3))  # point, component, side: strain per tz_j - tz_i
    bulge[:, :, 0] = slope[..., 0] * x[:, None]
    bulge[:, :, 1] = slope[..., 1] * y[:, None]
    bulge[:, :, 2] = slope[..., 1] * x[:, None] + slope[..., 0] * y[:, None]
    strain = np.repeat(linear_strain(t)[:, None], 3, axis=1)
    # Side k ends at END[k], and the side that starts there is END[k] as well.
    strain[..., 2::3] = bulge[..., _ending()] - bulge
    mean = excess_rotation(t).mean(axis=1, keepdims=True)
    weight = (SPURIOUS * A[..., 2, 2] * t.area)[:, None, None]
    return MembraneStrains(strain, np.swapaxes(mean, 1, 2) @ (weight * mean))


def _ending() -> list[int]:
    """The side that ends at each corner; side i starts at corner i."""
    return [END.index(corner) for corner in START]


MEMBRANE = Membrane("allman", allman, rotations=True, bow=1.0)
