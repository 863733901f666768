"""DST: the discrete shear triangle (Batoz and Lardeur 1989)."""

import numpy as np

from ....solver.math.arrays import Array
from ..triangles import END, START, Triangles
from .contract import Plate
from .strains import PlateStrains, curvature, side_differences

# `shear_ratio` above which the incompatible sides of this element have an effect: the error is
# about 2 % in constant curvature on an irregular patch, and in deflections of laminated plates.
SHEAR_RATIO_LIMIT = 0.1


def dst(t: Triangles, D: Array, Ds: Array) -> PlateStrains:
    """Strains of the discrete shear triangle.

    The shear forces follow from the moments by equilibrium within the triangle,

        T = (Mx,x + Mxy,y ; Mxy,x + My,y) = Ha alpha,    M = D k,

    where only the P_k of `strains` have second derivatives. This gives the constant shear strain
    gamma = Ds^-1 Ha alpha = Bsa alpha. With it on the sides, (side) of `strains` reads

        [(2/3) diag(L_k) - L_k t_k' Bsa] alpha = Aw u   ->   alpha = An u.

    Ds -> infinity gives DKT. If the plate is not thin compared with the *element* (`shear_ratio`
    not small), alpha_k differs between the two triangles at a side. Constant curvature is then
    not exact, and refinement does not help.
    """
    Bsa = np.linalg.solve(Ds, moment_slopes(t, D))
    sides = -t.length[..., None] * (t.tangent @ Bsa)
    sides[:, range(3), range(3)] += 2.0 / 3.0 * t.length
    An = np.asarray(np.linalg.solve(sides, side_differences(t)), dtype=np.float64)
    return PlateStrains(curvature(t, An), (Bsa @ An)[:, None])


def moment_slopes(t: Triangles, D: Array) -> Array:
    """Shear forces in equilibrium with the moments: T = Ha alpha, (c, 2, 3) [N/m].

    Parameters
    ----------
    D : (c|1, 3, 3) bending stiffness [N m], with all its couplings
    """
    gi, gj = t.grad[:, START], t.grad[:, END]
    xx, yy = 8.0 * gi[..., 0] * gj[..., 0], 8.0 * gi[..., 1] * gj[..., 1]  # of P_k
    xy = 4.0 * (gi[..., 0] * gj[..., 1] + gi[..., 1] * gj[..., 0])
    C, S = t.tangent[..., 0], t.tangent[..., 1]
    k_x = np.stack([C * xx, S * xy, C * xy + S * xx], axis=1)  # curvature differentiated by x
    k_y = np.stack([C * xy, S * yy, C * yy + S * xy], axis=1)
    return np.asarray(D[:, [0, 2]] @ k_x + D[:, [2, 1]] @ k_y)


PLATE = Plate("dst", dst, shear_ratio_limit=SHEAR_RATIO_LIMIT)
