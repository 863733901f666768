"""Common part of the plates of quadrilaterals: rotations with a quadratic tangential part.

As for triangles (plates/strains.py), with bilinear N_i and the functions P_k, 1 in the middle of
side k and 0 on the other three, P_1 = (1 - xi^2) (1 - eta)/2 and so on around the cell:

    b = sum_i N_i b_i + sum_k P_k t_k alpha_k,

and on each side L_k mean(gamma_s) = -Aw_k u + (2/3) L_k alpha_k                       (side)
"""

from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array
from ..plates.strains import curvature_at, shear_ratio
from ..quadrilaterals import GAUSS, Quadrilaterals


class QuadStrains(NamedTuple):
    """Strains of c plates for their degrees of freedom, in E, at the points `GAUSS`.

    Attributes
    ----------
    curvature : (c, 4, 3, 12) [1/m] of (kxx, kyy, kxy)
    shear : (c, 4, 2, 12) of (gxz, gyz)
    """

    curvature: Array
    shear: Array


def _bulges() -> Array:
    """Derivatives of P_k by xi and eta at the points, (point, side, 2)."""
    xi, eta = GAUSS.T
    half = 0.5
    by_xi = [-2 * xi * half * (1 - eta), half * (1 - eta**2), -2 * xi * half * (1 + eta),
             -half * (1 - eta**2)]  # fmt: skip
    by_eta = [-half * (1 - xi**2), -2 * eta * half * (1 + xi), half * (1 - xi**2),
              -2 * eta * half * (1 - xi)]  # fmt: skip
    return np.stack([np.array(by_xi).T, np.array(by_eta).T], axis=-1)


def _edges() -> Array:
    """Covariant shear strain (g_xi, g_eta) at the points for L_k gamma_k of 1, (point, 2, side).

    g_xi is linear between sides 1-2 and 4-3, g_eta between sides 2-3 and 1-4.
    """
    xi, eta = GAUSS.T
    fields = np.zeros((4, 2, 4))
    fields[:, 0, 0], fields[:, 0, 2] = 0.25 * (1 - eta), -0.25 * (1 + eta)
    fields[:, 1, 1], fields[:, 1, 3] = 0.25 * (1 + xi), -0.25 * (1 - xi)
    return fields


BULGES, EDGES = _bulges(), _edges()


def curvature(q: Quadrilaterals, An: Array | None) -> Array:
    """Curvature at the points, (c, 4, 3, 12) [1/m].

    Parameters
    ----------
    An : (c, 4, 12) alpha for the degrees of freedom, or None if the rotations are bilinear
    """
    # (c, point, side, 2) [1/m]
    slope = None if An is None else BULGES @ np.swapaxes(q.inverse, 2, 3)
    return curvature_at(q, q.grad, slope, An)


def edge_shear(q: Quadrilaterals, side: Array) -> Array:
    """Shear strain with a given constant tangential value on each side, (c, 4, 2, 12).

    Parameters
    ----------
    side : (c, 4, 12) gamma_k along each side for the degrees of freedom
    """
    fields = (q.inverse @ EDGES) * q.length[:, None, None, :]
    return np.asarray((fields.reshape(-1, 8, 4) @ side).reshape(-1, 4, 2, 12))


def side_ratio(q: Quadrilaterals, D: Array, Ds: Array) -> Array:
    """Ratio phi_k of each side with the part of the width (side_widths.py), (c, 4)."""
    length = shear_ratio(q, D, Ds)
    width = length * q.width_ratio
    return length + width * (1.0 + width)
