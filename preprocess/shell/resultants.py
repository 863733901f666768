"""Strains and resultants of shell triangles from their displacements."""

import numpy as np

from ...solver.math.arrays import Array
from .choice import Choice
from .membranes import MEMBRANES
from .plates import PLATES
from .plates.dst import moment_slopes
from .plates.strains import side_differences
from .stiffness import AT_A_TIME, MEMBRANE, PLATE, SIGN, Stiffness, cell_stiffness
from .triangles import Triangles


def element_strains(t: Triangles, laminate: Stiffness, choice: Choice, u_G: Array) -> Array:
    """Mean strains of each triangle in E, (c, 8, m): exx eyy gxy, kxx kyy kxy [1/m], gxz gyz.

    Parameters
    ----------
    t : c triangles
    laminate : A, B, D, Ds in E, one for all or one for each triangle
    choice : the elements
    u_G : (c, 18, m) displacements [m] and rotations [rad] of the corners, m states at once

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
        A, _, D, Ds = (a[some] if len(a) > 1 else a for a in given)
        part = t[some]
        u_m, u_b = own_displacements(part, u_G[some])
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


def element_resultants(t: Triangles, laminate: Stiffness, choice: Choice, u_G: Array) -> Array:
    """Mean resultants of each triangle in E, (c, 8, m): N [N/m] 3, M [N] 3, T [N/m] 2.

    Order N_xx N_yy N_xy, M_xx M_yy M_xy, T_x T_y. Arguments and errors as in `element_strains`.

    Paper: Eq. (28).
    """
    A, B, D, Ds = cell_stiffness(laminate)
    strains = element_strains(t, laminate, choice, u_G)
    e, k, gamma = strains[:, :3], strains[:, 3:6], strains[:, 6:]
    return np.concatenate([A @ e + B @ k, B @ e + D @ k, Ds @ gamma], axis=1)


def own_displacements(t: Triangles, u_G: Array) -> tuple[Array, Array]:
    """Degrees of freedom of the membrane and of the plate in E, each (c, 9, m).

    Paper: Eq. (23).

    Parameters
    ----------
    u_G : (c, 18, m) of the corners in G
    """
    c, _, m = u_G.shape
    u_E = np.swapaxes(t.A_GE, 1, 2)[:, None] @ u_G.reshape(c, 6, 3, m)
    u = u_E.reshape(c, 3, 6, m)
    u_m = u[:, :, MEMBRANE]
    u_b = u[:, :, PLATE] * np.array(SIGN)[:, None]
    return u_m.reshape(c, 9, m), u_b.reshape(c, 9, m)
