"""Mass of the cross-section per unit length."""

import numpy as np

from ...solver.package.schema import Array
from .forms import SectionSpace


def mass_matrix(space: SectionSpace, density: Array) -> Array:
    """Consistent mass per length M (6, 6): kinetic energy v' M v / 2 per metre.

    Parameters
    ----------
    space : the section's mesh
    density : (n_cell,) [kg/m3]

    Returns
    -------
    (6, 6) for the velocities v = [v1, v2, v3, w1, w2, w3] of the origin of the section axes
    [kg/m, kg, kg m].
    """
    x2, x3 = space.x2, space.x3
    motions = space.displacements(
        (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -x3, x2), (x3, 0, 0), (-x2, 0, 0)
    )
    M = motions.T @ (space.gram(density) @ motions)
    return 0.5 * (M + M.T)


def mass_centre(M: Array) -> Array:
    """(x2, x3) of the mass centre, (2,) [m]."""
    return np.array([-M[0, 5], M[0, 4]]) / M[0, 0]
