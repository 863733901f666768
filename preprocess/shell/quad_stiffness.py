"""Stiffness of shell quadrilaterals: hybrid membrane and plate, coupled, with warped corners.

The nodes of a warped quadrilateral lie at heights d above its mean plane. The plate is that of the
plane; the membrane has the displacements of the feet of its nodes, u - d ty and v + d tx.
"""

import numpy as np

from ...solver.math.arrays import Array
from .choice import Choice
from .membranes import MEMBRANES
from .quadrilaterals import Quadrilaterals
from .quads import QUADS, hybrid, internal
from .rotation import own_displacements, to_G, together

WARPED = 1e-9  # height over the size of a cell, above which it counts


def quad_stiffness(
    q: Quadrilaterals, A: Array, B: Array, D: Array, Ds: Array, choice: Choice
) -> Array:
    """Stiffness of quadrilaterals in G, (c, 24, 24) [N/m, N, N m]; A, B, D, Ds in E, (c|1, ..)."""
    element = QUADS[choice.quadrilateral]
    plate = element.strains(q, D, Ds)
    A_inverse: Array = np.asarray(np.linalg.inv(A), dtype=float)
    H = hybrid.flexibility(q, A_inverse)
    G = hybrid.stretching(q, MEMBRANES[choice.membrane].bow)
    coupled = bool(B.any())
    if coupled:
        G = np.concatenate([G, hybrid.bending(q, A_inverse, B, plate.curvature)], axis=2)
        D = D - B @ A_inverse @ B
    K = np.swapaxes(G, 1, 2) @ np.linalg.solve(H, G)
    K_m = K[:, :12, :12] + hybrid.steadying(q, A)
    K_b = _weighted(q, D, plate.curvature) + _weighted(q, Ds, plate.shear)
    if element.internal:
        K_b -= internal.relief(q, D, Ds, plate.shear)
    K_mb = None
    if coupled:
        K_b += K[:, 12:, 12:]
        K_mb = K[:, :12, 12:]
    K_E = _on_nodes(q, together(K_m, K_b, K_mb))
    return to_G(q.A_GE, 0.5 * (K_E + np.swapaxes(K_E, 1, 2)))


def quad_strains(
    q: Quadrilaterals, A: Array, B: Array, D: Array, Ds: Array, choice: Choice, u_G: Array
) -> Array:
    """Mean strains of quadrilaterals in E, (c, 8, m), of displacements (c, 24, m) in G."""
    plate = QUADS[choice.quadrilateral].strains(q, D, Ds)
    u_m, u_b = at_feet(q, u_G)
    A_inverse: Array = np.asarray(np.linalg.inv(A), dtype=float)
    work: Array = hybrid.stretching(q, MEMBRANES[choice.membrane].bow) @ u_m
    share = q.weight / q.area[:, None]
    k = np.einsum("cq,cqij->cij", share, plate.curvature) @ u_b
    if B.any():
        work = work + hybrid.bending(q, A_inverse, B, plate.curvature) @ u_b
    N = np.linalg.solve(hybrid.flexibility(q, A_inverse), work)[:, :3]  # mean: x, y are central
    gamma = np.einsum("cq,cqij->cij", share, plate.shear) @ u_b
    return np.concatenate([A_inverse @ (N - B @ k), k, gamma], axis=1)


def at_feet(q: Quadrilaterals, u_G: Array) -> tuple[Array, Array]:
    """`own_displacements`, the membrane's at the feet of the nodes in the mean plane."""
    u_m, u_b = own_displacements(q.A_GE, u_G)
    d = q.height[..., None]
    u_m[:, 0::3] -= d * u_b[:, 1::3]  # bx = ty
    u_m[:, 1::3] -= d * u_b[:, 2::3]  # by = -tx
    return u_m, u_b


def _weighted(q: Quadrilaterals, C: Array, strain: Array) -> Array:
    """int strain' C strain over the points of strain (c, 4, n, 12), (c, 12, 12)."""
    c, p, n, k = strain.shape
    stress = (q.weight[..., None, None] * C[:, None]) @ strain
    flat = strain.reshape(c, p * n, k)
    return np.asarray(np.swapaxes(flat, 1, 2) @ stress.reshape(c, p * n, k))


def _on_nodes(q: Quadrilaterals, K: Array) -> Array:
    """W' K W with the feet's displacements W u, in E, (c, 24, 24)."""
    if not np.any(np.abs(q.height).max(axis=1, initial=0.0) > WARPED * np.sqrt(q.area)):
        return K
    d = q.height[:, None]
    K = K.copy()
    for _ in range(2):  # columns of K, then of its transpose
        K[:, :, 4::6] -= d * K[:, :, 0::6]
        K[:, :, 3::6] += d * K[:, :, 1::6]
        K = np.ascontiguousarray(np.swapaxes(K, 1, 2))
    return K
