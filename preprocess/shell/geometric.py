"""Geometric stiffness: work of the resultants of a prestress on the second-order strains.

With constant N in each element, displacements interpolated from the corners, and the rotation
about the normal r = (v,x - u,y)/2,

    u' Kg u = int N_ab w,a w,b + (N_xx + N_yy) r^2 dA.

The second term is the part of the in-plane gradients that is not of the order of the pre-strain. A
rigid rotation has the exact second-order work, a column may buckle in the plane of its wall, and
no axes are preferred. Tables of plates have the first term only. The rotation tz and terms of
N h^2/12 have no part.
"""

import numpy as np

from ...solver.math.arrays import Array
from .quadrilaterals import Quadrilaterals
from .rotation import to_G
from .triangles import Triangles


def element_geometric(t: Triangles | Quadrilaterals, N: Array, in_plane: bool = True) -> Array:
    """Geometric stiffness of shell elements in G, (c, 6 k, 6 k) [N/m].

    Parameters
    ----------
    t : c elements of k corners
    N : (c, 3) mean resultants Nxx, Nyy, Nxy in E [N/m], tension positive
    in_plane : with the work on rotations about the normal
    """
    grad, weight = gradients(t)
    k = grad.shape[2]
    tensor = N[:, [0, 2, 2, 1]].reshape(-1, 1, 2, 2)
    K = np.zeros((len(N), k, 6, k, 6))
    weighted = grad * weight[..., None, None]
    K[:, :, 2, :, 2] = (weighted @ tensor @ np.swapaxes(grad, 2, 3)).sum(axis=1)
    if in_plane:
        trace = (N[:, 0] + N[:, 1])[:, None, None]
        turn = 0.5 * np.stack([-grad[..., 1], grad[..., 0]])  # of u and v
        for i in range(2):
            for j in range(2):
                products = np.swapaxes(turn[i] * weight[..., None], 1, 2) @ turn[j]
                K[:, :, i, :, j] = trace * products
    return to_G(t.A_GE, K.reshape(-1, 6 * k, 6 * k))


def element_pressure(t: Triangles | Quadrilaterals, p: Array) -> Array:
    """Stiffness of a pressure that stays normal to its elements, in G, (c, 6 k, 6 k) [N/m].

    The area vector of a displaced element is e3 + (u,x + v,y) e3 - w,x e1 - w,y e2 per area; minus
    the derivatives of the nodal forces by the displacements, their symmetric part. On a closed
    surface, and where the edges are held, the sum over all elements is symmetric by itself.

    Parameters
    ----------
    p : (c, q) pressure along e3 at the integration points [N/m2]
    """
    N, grad = t.interpolation, t.grad
    if isinstance(t, Triangles):
        grad = np.broadcast_to(grad[:, None], (len(grad), 3, 3, 2))
    k = N.shape[1]
    weighted = (p * t.weight)[:, :, None] * N  # (c, q, k)
    slopes = np.einsum("cqi,cqja->caij", weighted, grad)  # int p N_i N_j,a
    K = np.zeros((len(p), k, 6, k, 6))
    for a in range(2):
        both = 0.5 * (np.swapaxes(slopes[:, a], 1, 2) - slopes[:, a])
        K[:, :, 2, :, a] = both
        K[:, :, a, :, 2] = np.swapaxes(both, 1, 2)
    return to_G(t.A_GE, K.reshape(-1, 6 * k, 6 * k))


def gradients(t: Triangles | Quadrilaterals) -> tuple[Array, Array]:
    """Gradients of the corners' functions (c, q, k, 2) [1/m], and areas (c, q) [m2]."""
    if isinstance(t, Triangles):
        return t.grad[:, None], t.area[:, None]
    return t.grad, t.weight
