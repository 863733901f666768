"""Mass of the cross-section per unit length."""

import numpy as np

from ...solver.math.arrays import Array
from .space import SectionSpace


def mass_matrix(space: SectionSpace, density: Array) -> Array:
    """Mass per length M (6, 6): kinetic energy v' M v / 2 per metre.

    Parameters
    ----------
    space : the section's integration points
    density : (c, q) at the points [kg/m3]

    Returns
    -------
    (6, 6) for the velocities v = [v1, v2, v3, w1, w2, w3] of the origin of the section axes
    [kg/m, kg, kg m].
    """
    x2, x3 = np.moveaxis(space.points, -1, 0)
    rigid = np.zeros((*x2.shape, 3, 6))  # velocity of a point
    rigid[..., [0, 1, 2], [0, 1, 2]] = 1.0
    rigid[..., 0, 4], rigid[..., 0, 5] = x3, -x2
    rigid[..., 1, 3], rigid[..., 2, 3] = -x3, x2
    columns = rigid.reshape(-1, 6)
    weights = np.repeat((density * space.weights).ravel(), 3)
    M = columns.T @ (weights[:, None] * columns)
    return np.asarray(0.5 * (M + M.T))


def mass_centre(M: Array) -> Array:
    """(x2, x3) of the mass centre, (2,) [m]; the origin if there is no mass."""
    if M[0, 0] == 0.0:
        return np.zeros(2)
    return np.array([-M[0, 5], M[0, 4]]) / M[0, 0]
