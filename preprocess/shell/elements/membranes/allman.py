"""Allman's triangle: quadratic displacements driven by the rotations of the corners."""

from ufl import as_vector

from ..cell import Cell
from .contract import Membrane, MembraneStrains, bow_strain, linear_strain

# Relative to A66, stiffness of equal rotations of all corners. It affects warped shells: with a
# hundredth of this value a twisted beam becomes too soft with refinement, by a tenth at 8 cells
# across.
SPURIOUS = 0.1


def allman(t: Cell) -> MembraneStrains:
    """Strains of the triangle of Allman.

    The middle of a side is displaced from its chord in the direction n_k = (t_y, -t_x) by
    (L_k/8)(tz_j - tz_i):

        (u, v) = sum_i l_i (u, v)_i + sum_k P_k (L_k/8)(tz_j - tz_i) n_k,   P_k = 4 l_i l_j,

    whose strain is linear. Equal tz at all corners cause no displacement; the extra stiffness
    0.1 A66 area m^2 with m = mean(tz) - (v,x - u,y)/2 acts on them.
    """
    m = as_vector([sum(t.excess(t.corners)) / 3.0])
    strain = [linear_strain(point, t.corners) + bow_strain(t, point) for point in t.points]
    return MembraneStrains(strain, [(SPURIOUS * t.A[2, 2] * t.area * m, m)])


MEMBRANE = Membrane("allman", allman, rotations=True, bow=1.0)
