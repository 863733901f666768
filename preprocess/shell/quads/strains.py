"""Common part of the plates of quadrilaterals: rotations with a quadratic tangential part.

As for triangles (plates/strains.py), with bilinear N_i and the functions P_k, 1 in the middle of
side k and 0 on the other three, P_1 = (1 - xi^2) (1 - eta)/2 and so on around the cell:

    b = sum_i N_i b_i + sum_k P_k t_k alpha_k,

and on each side L_k mean(gamma_s) = -Aw_k u + (2/3) L_k alpha_k                       (side)
"""

from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array
from ..plates.strains import shear_ratio
from ..quadrilaterals import END, GAUSS, START, Quadrilaterals


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


def side_differences(q: Quadrilaterals) -> Array:
    """Aw (c, 4, 12): Aw_k u = w_i - w_j - (L_k/2) t_k.(b_i + b_j) [m], of each side."""
    half = -0.5 * q.length[..., None] * q.tangent
    Aw = np.zeros((len(q), 4, 4, 3))
    for k, (i, j) in enumerate(zip(START, END, strict=True)):
        Aw[:, k, i, 0], Aw[:, k, j, 0] = 1.0, -1.0
        Aw[:, k, i, 1:] = Aw[:, k, j, 1:] = half[:, k]
    return Aw.reshape(-1, 4, 12)


def curvature(q: Quadrilaterals, An: Array | None) -> Array:
    """Curvature at the points, (c, 4, 3, 12) [1/m].

    Parameters
    ----------
    An : (c, 4, 12) alpha for the degrees of freedom, or None if the rotations are bilinear
    """
    c = len(q)
    Bb = np.zeros((c, 4, 3, 12))
    if An is not None:
        slope = BULGES @ np.swapaxes(q.inverse, 2, 3)  # (c, point, side, 2) [1/m]
        along = q.tangent[:, None]
        Ba = np.empty((c, 4, 3, 4))  # point, component, side
        Ba[:, :, :2] = np.swapaxes(slope * along, 2, 3)
        Ba[:, :, 2] = slope[..., 1] * along[..., 0] + slope[..., 0] * along[..., 1]
        np.matmul(Ba.reshape(c, 12, 4), An, out=Bb.reshape(c, 12, 12))
    gx, gy = q.grad[..., 0], q.grad[..., 1]
    Bb[:, :, 0, 1::3] += gx
    Bb[:, :, 1, 2::3] += gy
    Bb[:, :, 2, 1::3] += gy
    Bb[:, :, 2, 2::3] += gx
    return Bb


def edge_shear(q: Quadrilaterals, side: Array) -> Array:
    """Shear strain with a given constant tangential value on each side, (c, 4, 2, 12).

    Parameters
    ----------
    side : (c, 4, 12) gamma_k along each side for the degrees of freedom
    """
    fields = (q.inverse @ EDGES) * q.length[:, None, None, :]
    return np.asarray((fields.reshape(-1, 8, 4) @ side).reshape(-1, 4, 2, 12))


def side_ratio(q: Quadrilaterals, D: Array, Ds: Array) -> Array:
    """`shear_ratio` of each side, times the factor of the side, (c, 4)."""
    return shear_ratio(q, D, Ds) * q.side_factor
