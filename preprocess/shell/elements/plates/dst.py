"""DST: the discrete shear triangle (Batoz and Lardeur 1989)."""

from typing import Any

from ufl import as_matrix, as_vector, inv

from ..cell import Cell
from .contract import Plate, PlateStrains, curvature, side_differences

# `shear_ratio` above which the incompatible sides of this element have an effect: the error is
# about 2 % in constant curvature on an irregular patch, and in deflections of laminated plates.
SHEAR_RATIO_LIMIT = 0.1


def dst(t: Cell) -> PlateStrains:
    """Strains of the discrete shear triangle.

    The shear forces follow from the moments by equilibrium within the triangle,

        T = (Mx,x + Mxy,y ; Mxy,x + My,y) = Ha alpha,    M = D k,

    where only the P_k of contract.py have second derivatives. This gives the constant shear strain
    gamma = Ds^-1 Ha alpha = Bsa alpha. With it on the sides, (side) of contract.py reads

        [(2/3) diag(L_k) - L_k t_k' Bsa] alpha = Aw.

    Ds -> infinity gives DKT. If the plate is not thin compared with the *element* (`shear_ratio`
    not small), alpha_k differs between the two triangles at a side. Constant curvature is then
    not exact, and refinement does not help.
    """
    L, Bsa = t.length, inv(t.Ds) * moment_slopes(t)
    along = as_matrix([[L[k] * t.tangent[k][i] for i in range(2)] for k in range(3)])
    sides = as_matrix([[2.0 / 3.0 * L[k] * (k == n) for n in range(3)] for k in range(3)])
    alpha = inv(sides - along * Bsa) * as_vector(side_differences(t))
    return PlateStrains(curvature(t, [alpha[k] for k in range(3)]), [Bsa * alpha])


def moment_slopes(t: Cell) -> Any:
    """Ha (2, 3) [N/m], with all the couplings of the bending stiffness D."""
    columns = []
    for (i, j), (C, S) in zip(t.sides, t.tangent, strict=True):
        gi, gj = t.centre[i], t.centre[j]
        xx, yy = 8.0 * gi[0] * gj[0], 8.0 * gi[1] * gj[1]  # second derivatives of P_k
        xy = 4.0 * (gi[0] * gj[1] + gi[1] * gj[0])
        k_x = (C * xx, S * xy, C * xy + S * xx)  # curvature differentiated by x
        k_y = (C * xy, S * yy, C * yy + S * xy)
        columns.append(
            [
                sum(t.D[row, n] * k_x[n] + t.D[other, n] * k_y[n] for n in range(3))
                for row, other in ((0, 2), (2, 1))
            ]
        )
    return as_matrix([[column[row] for column in columns] for row in range(2)])


PLATE = Plate("dst", dst, shear_ratio_limit=SHEAR_RATIO_LIMIT)
