"""Strains and resultants of shell elements from their displacements."""

import numpy as np

from ...solver.math.arrays import Array
from .choice import Choice
from .membranes import MEMBRANES
from .plates import PLATES
from .plates.dst import moment_slopes
from .plates.strains import side_differences
from .quad_stiffness import quad_strains
from .quadrilaterals import Quadrilaterals
from .rotation import own_displacements
from .stiffness import AT_A_TIME, Stiffness, cell_stiffness
from .triangles import Triangles


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
    choice.checked()
    given = cell_stiffness(laminate)
    strains = np.empty((len(t), 8, u_G.shape[2]))
    for first in range(0, len(t), AT_A_TIME):
        some = slice(first, first + AT_A_TIME)
        A, B, D, Ds = (a[some] if len(a) > 1 else a for a in given)
        part = t[some]
        if isinstance(part, Quadrilaterals):
            strains[some] = quad_strains(part, A, B, D, Ds, choice, u_G[some])
            continue
        u_m, u_b = own_displacements(part.A_GE, u_G[some])
        plate = PLATES[choice.plate].strains(part, D, Ds)
        membrane = MEMBRANES[choice.membrane].strains(part, A, choice.beta0)
        strains[some, :3] = membrane.mean_strain @ u_m
        strains[some, 3:6] = plate.curvature.mean(axis=1) @ u_b
        if plate.shear.shape[1]:
            strains[some, 6:] = plate.shear.mean(axis=1) @ u_b
        else:  # without shear strain, the shear forces follow from the moments
            alpha = side_differences(part) @ u_b * (1.5 / part.length)[..., None]
            strains[some, 6:] = np.linalg.solve(Ds, moment_slopes(part, D) @ alpha)
    return strains


def element_resultants(
    t: Triangles | Quadrilaterals, laminate: Stiffness, choice: Choice, u_G: Array
) -> Array:
    """Mean resultants of each element in E, (c, 8, m): N [N/m] 3, M [N] 3, T [N/m] 2.

    Order N_xx N_yy N_xy, M_xx M_yy M_xy, T_x T_y. Arguments and errors as in `element_strains`.

    Paper: Eq. (28).
    """
    A, B, D, Ds = cell_stiffness(laminate)
    strains = element_strains(t, laminate, choice, u_G)
    e, k, gamma = strains[:, :3], strains[:, 3:6], strains[:, 6:]
    return np.concatenate([A @ e + B @ k, B @ e + D @ k, Ds @ gamma], axis=1)
