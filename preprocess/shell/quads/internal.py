"""Internal rotations of a quadrilateral that is narrow compared with its thickness.

In torsion of a narrow strip the rotation along the strip is a hyperbolic sine across its width, and
bilinear rotations of one cell are too stiff by up to 13 %. Each cell therefore has two rotations of
its own, of cubic shape f(s) = s^3 - s, zero on the sides that they run along:

    b = c_1 t_1 f(eta) + c_2 t_2 f(xi),

with unit vectors t_1, t_2 along xi and eta at the centre. The mean of their curvature and of their
shear strain is zero (both are taken with the derivatives of the centre), so every constant state
is kept; they only answer to a shear strain along one direction that varies across it. Integrals
over a square of side 2: int f'^2 = 16/5, int f^2 = 32/105, and int f g = -(2/5) int s g for g
linear in s. The curvature of the corners' motion does no work on f'. All other products of the two
vanish, so each is eliminated alone.
"""

import numpy as np

from ....solver.math.arrays import Array
from ..quadrilaterals import GAUSS, Quadrilaterals, slopes

CURVED, SHEARED, ANSWER = 16.0 / 5.0, 32.0 / 105.0, -2.0 / 5.0
CENTRE = slopes(np.zeros((1, 2)))[0]


def relief(q: Quadrilaterals, D: Array, Ds: Array, shear: Array) -> Array:
    """Stiffness that the internal rotations take from the plate, (c, 12, 12).

    Parameters
    ----------
    D : (c|1, 3, 3) bending stiffness with free membrane resultants [N m]
    Ds : (c|1, 2, 2) transverse shear stiffness [N/m]
    shear : (c, 4, 2, 12) shear strain at the points `GAUSS`
    """
    J = CENTRE.T @ q.xy_E  # (c, a, i) of x_i by xi_a
    area = np.abs(np.linalg.det(J))
    gradient = np.swapaxes(np.linalg.inv(J), 1, 2)[:, ::-1]  # of the other coordinate, (c, a, i)
    t = J / np.linalg.norm(J, axis=2, keepdims=True)
    k = np.stack(
        [
            t[..., 0] * gradient[..., 0],
            t[..., 1] * gradient[..., 1],
            t[..., 0] * gradient[..., 1] + t[..., 1] * gradient[..., 0],
        ],
        axis=-1,
    )
    along = t @ Ds  # (c, a, 2)
    own = CURVED * ((k @ D) * k).sum(axis=-1) + SHEARED * (along * t).sum(axis=-1)  # (c, a)
    variation = GAUSS[:, ::-1].T @ shear.reshape(len(q), 4, 24)  # sum of s g, (c, a, 24)
    work = ANSWER * (along[:, :, None] @ variation.reshape(len(q), 2, 2, 12))[:, :, 0]
    return np.asarray(np.swapaxes(work * (area[:, None] / own)[..., None], 1, 2) @ work)
