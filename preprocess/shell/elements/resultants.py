"""Strains and resultants of shell elements from their displacements."""

import numpy as np

from ....solver.math.arrays import Array
from ..mesh.quadrilaterals import Quadrilaterals
from ..mesh.triangles import Triangles
from .choice import Choice
from .pairs import stiffness_kernel
from .single_cells import cell_rows
from .table import Stiffness, cell_table

AT_A_TIME = 512  # cells whose rows are in memory together


def element_strains(
    t: Triangles | Quadrilaterals, laminate: Stiffness, choice: Choice, u_G: Array
) -> Array:
    """Mean strains of each element in E, (c, 8, m): exx eyy gxy, kxx kyy kxy [1/m], gxz gyz.

    Parameters
    ----------
    t : c triangles or quadrilaterals
    laminate : A, B, D, Ds in E, one for all or one for each triangle
    choice : the elements
    u_G : (c, 18|24, m) displacements [m] and rotations [rad] of the corners, m states at once

    Raises
    ------
    ShellError
        for a choice that does not exist
    """
    kernel = stiffness_kernel(t.xy_E.shape[1], choice, drilling=False)
    table = cell_table(t, laminate, choice)
    strains = np.empty((len(t), 8, u_G.shape[2]))
    for first in range(0, len(t), AT_A_TIME):
        some = slice(first, first + AT_A_TIME)
        means = [mean for _, _, mean in cell_rows(t[some], kernel, table[some])]
        strains[some] = np.concatenate(means, axis=1) @ u_G[some]
    return strains


def element_resultants(
    t: Triangles | Quadrilaterals, laminate: Stiffness, choice: Choice, u_G: Array
) -> Array:
    """Mean resultants of each element in E, (c, 8, m): N [N/m] 3, M [N] 3, T [N/m] 2.

    Order N_xx N_yy N_xy, M_xx M_yy M_xy, T_x T_y. Arguments and errors as in `element_strains`.

    Paper: Eq. (28).
    """
    A, B, D = (np.reshape(a, (-1, 3, 3)) for a in (laminate.A, laminate.B, laminate.D))
    strains = element_strains(t, laminate, choice, u_G)
    e, k, gamma = strains[:, :3], strains[:, 3:6], strains[:, 6:]
    return np.concatenate([A @ e + B @ k, B @ e + D @ k, laminate.Ds @ gamma], axis=1)
