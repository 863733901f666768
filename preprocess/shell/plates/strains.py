"""Common part of the plates: rotations with a quadratic tangential part on each side.

With area coordinates l_i, P_k = 4 l_i l_j on side k from corner i to j of length L_k and unit
tangent t_k, the rotation b = (bx, by) of the normal is

    b = sum_i l_i b_i + sum_k P_k t_k alpha_k,

linear along a side in the direction normal to it, quadratic along it; so the curvature is
k = Bb0 u + Ba alpha with u = (w1, bx1, by1, w2, ..). Integrated along a side, the shear strain
gamma_s = w,s + t.b is

    L_k mean(gamma_s) = w_j - w_i + (L_k/2) t_k.(b_i + b_j) + (2/3) L_k alpha_k
                      = -Aw_k u + (2/3) L_k alpha_k.                                   (side)

Each plate adds its own condition on gamma_s, which gives alpha = An u.
"""

from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array
from ..quadrilaterals import Quadrilaterals
from ..sides import bulge_slopes, edge_fields
from ..triangles import Triangles


class PlateStrains(NamedTuple):
    """Strains of c plates for their degrees of freedom, in E.

    Paper: Eq. (27).

    Attributes
    ----------
    curvature : (c, 3, 3, 9) [1/m] of (kxx, kyy, kxy) at the three integration points
    shear : (c, q, 2, 9) of (gxz, gyz), q = 3 at the same points, 1 where it is constant,
        0 where there is none
    """

    curvature: Array
    shear: Array


def side_differences(t: Triangles | Quadrilaterals) -> Array:
    """Aw (c, n, 3 n): Aw_k u = w_i - w_j - (L_k/2) t_k.(b_i + b_j) [m], of each of n sides."""
    half = -0.5 * t.length[..., None] * t.tangent
    n = t.length.shape[1]
    Aw = np.zeros((len(t), n, n, 3))
    for k in range(n):
        i, j = k, (k + 1) % n  # its ends
        Aw[:, k, i, 0], Aw[:, k, j, 0] = 1.0, -1.0
        Aw[:, k, i, 1:] = Aw[:, k, j, 1:] = half[:, k]
    return Aw.reshape(-1, n, 3 * n)


def curvature(t: Triangles, An: Array | None) -> Array:
    """Curvature Bb0 + Ba An at the integration points, (c, 3, 3, 9) [1/m].

    Parameters
    ----------
    An : (c, 3, 9) alpha for the degrees of freedom, or None if the rotations are linear
    """
    return curvature_at(t, t.grad[:, None], None if An is None else bulge_slopes(t), An)


def curvature_at(
    t: Triangles | Quadrilaterals, grad: Array, slope: Array | None, An: Array | None
) -> Array:
    """Curvature of cells with n corners at p = n points, (c, n, 3, 3 n) [1/m].

    Parameters
    ----------
    grad : (c, p|1, n, 2) gradients of the functions of the corners [1/m]
    slope : (c, p, n, 2) gradients of the functions P_k of the sides [1/m], unless An is None
    An : (c, n, 3 n) alpha for the degrees of freedom, or None if the rotations have no P_k
    """
    c, n = t.length.shape
    Bb = np.zeros((c, n, 3, 3 * n))
    if An is not None and slope is not None:
        along = t.tangent[:, None]
        Ba = np.empty((c, n, 3, n))  # point, component, side
        Ba[:, :, :2] = np.swapaxes(slope * along, 2, 3)
        Ba[:, :, 2] = slope[..., 1] * along[..., 0] + slope[..., 0] * along[..., 1]
        np.matmul(Ba.reshape(c, 3 * n, n), An, out=Bb.reshape(c, 3 * n, 3 * n))
    gx, gy = grad[..., 0], grad[..., 1]
    Bb[:, :, 0, 1::3] += gx
    Bb[:, :, 1, 2::3] += gy
    Bb[:, :, 2, 1::3] += gy
    Bb[:, :, 2, 2::3] += gx
    return Bb


def edge_shear(t: Triangles, side: Array) -> Array:
    """Shear strain with a given constant tangential value on each side, (c, 3, 2, 9).

    gamma = sum_k L_k (l_i g_j - l_j g_i) gamma_k, the edge interpolation of lowest order.

    Parameters
    ----------
    side : (c, 3, 9) gamma_k along each side for the degrees of freedom
    """
    fields = np.swapaxes(edge_fields(t), 2, 3)
    return np.asarray((fields.reshape(-1, 6, 3) @ side).reshape(-1, 3, 2, 9))


def shear_ratio(t: Triangles | Quadrilaterals, D: Array, Ds: Array) -> Array:
    """Ratio of shear flexibility to bending flexibility of each side: phi (c, 3|4).

    phi_k = 12 D_ss / (Ds_ss L_k^2) with D_ss = q' D q, q = (C^2, S^2, 2 C S) the moment about
    the side's normal for a unit curvature along the side, and Ds_ss = t' Ds t. Isotropic:
    2 / (kappa (1 - nu)) (h / L_k)^2.

    Parameters
    ----------
    D : (c|1, 3, 3) bending stiffness [N m]
    Ds : (c|1, 2, 2) transverse shear stiffness [N/m]
    """
    C, S = t.tangent[..., 0], t.tangent[..., 1]
    q = np.stack([C * C, S * S, 2.0 * C * S], axis=-1)
    D_ss = ((q @ D) * q).sum(axis=-1)
    Ds_ss = ((t.tangent @ Ds) * t.tangent).sum(axis=-1)
    return np.asarray(12.0 * D_ss / (Ds_ss * t.length**2))
