"""Mass of shell elements with the displacements and rotations of their corners interpolated.

A point z above the reference surface moves by (20)-(22) of the paper: u + z bx, v + z by, w. With
m0, m1, m2 the moments of the density over the thickness, the kinetic energy per area is

    m0/2 (u'^2 + v'^2 + w'^2) + m1 (u' bx' + v' by') + m2/2 (bx'^2 + by'^2).

The drilling rotation moves no mass. In the consistent form, m2 acts on its difference from the
rotation of the triangle, so every rigid motion has its exact energy. In the lumped form, m2 acts on
it as on the other rotations, so without m1 the matrix is diagonal in all axes.
"""

import numpy as np

from ...solver.math.arrays import Array
from ...solver.package.body.schema import MASS_FORMS
from .drilling.excess import excess_rotation
from .drilling.tie import LINEAR
from .errors import ShellError
from .quadrilaterals import Quadrilaterals
from .quads import hybrid
from .rotation import MEMBRANE, to_G
from .stiffness import AT_A_TIME
from .triangles import Triangles

THIRDS = np.eye(3) / 3.0


def element_mass(t: Triangles | Quadrilaterals, mass: Array, form: str = "consistent") -> Array:
    """Mass of shell elements in G, (c, 18, 18) or (c, 24, 24) [kg, kg m, kg m2].

    Paper: Eq. (20), Eq. (21), Eq. (22), Eq. (31).

    Parameters
    ----------
    t : c triangles or quadrilaterals
    mass : (3,) or (c, 3) m0 [kg/m2], m1 [kg/m], m2 [kg] of the laminate
    form : "consistent", or "lumped": the area of a corner's function at each corner, a third
        of a triangle, so that corners are not coupled

    Raises
    ------
    ShellError
        for another form
    """
    if form not in MASS_FORMS:
        raise ShellError(f"mass form {form!r}: expected one of {', '.join(MASS_FORMS)}")
    m = np.asarray(mass, dtype=float).reshape(-1, 3)
    size = 6 * t.xy_E.shape[1]
    M_G = np.empty((len(t), size, size))
    for first in range(0, len(t), AT_A_TIME):
        some = slice(first, first + AT_A_TIME)
        M_G[some] = _mass(t[some], m[some] if len(m) > 1 else m, form)
    return M_G


def _mass(t: Triangles | Quadrilaterals, mass: Array, form: str) -> Array:
    consistent = form == "consistent"
    k = t.xy_E.shape[1]
    if isinstance(t, Triangles):
        spread = LINEAR if consistent else THIRDS
        m0, m1, m2 = (t.area[:, None, None] * m[:, None, None] * spread for m in mass.T)
    else:
        areas = _corner_products(t, consistent)
        m0, m1, m2 = (m[:, None, None] * areas for m in mass.T)
    M = np.zeros((len(t), k, 6, k, 6))
    for i in range(3):
        M[:, :, i, :, i] = m0
    for i in (3, 4) if consistent else (3, 4, 5):
        M[:, :, i, :, i] = m2
    for i, j, moment in ((0, 4, m1), (1, 3, -m1)):  # bx = ry, by = -rx
        M[:, :, i, :, j] = M[:, :, j, :, i] = moment
    if consistent:
        T = excess_rotation(t) if isinstance(t, Triangles) else hybrid.excess_rotation(t)
        drilling = (np.swapaxes(T, 1, 2) @ m2 @ T).reshape(-1, k, 3, k, 3)
        for i, row in enumerate(MEMBRANE):
            for j, column in enumerate(MEMBRANE):
                M[:, :, row, :, column] += drilling[:, :, i, :, j]
    return to_G(t.A_GE, M.reshape(-1, 6 * k, 6 * k))


def _corner_products(q: Quadrilaterals, consistent: bool) -> Array:
    """int N_i N_j, or the diagonal matrix of int N_i, (c, 4, 4) [m2]."""
    N = q.interpolation
    if not consistent:
        return np.asarray((q.weight @ N)[:, :, None] * np.eye(4))
    return np.asarray((q.weight[:, None] * N.T) @ N)
