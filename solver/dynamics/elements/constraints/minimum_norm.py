"""Accelerations and multipliers for redundant or rank-deficient constraints."""

import numpy as np

from ....math.arrays import Array
from ...tolerances import RANK_TOLERANCE
from .treatment import row_masses


def minimum_norm(
    M: Array, f: Array, Phi_q: Array, gamma: Array, inertia_scale: Array, redundant: int
) -> tuple[Array, Array]:
    """Return accelerations (n,) and the multipliers (n_c,) of least norm.

    Singular value decomposition C = U Sigma V' of the scaled Jacobian (`scaled_jacobian`): the
    accelerations along V follow from gamma, those in its null space from the loads, and the
    multipliers from the remaining equations. Multipliers of redundant joints are not unique;
    these are the least-squares ones in the metric of the scaling.

    At most n_c - `redundant` singular values are used. The others are zero for the exact motion
    but not for a computed one, and division by them would amplify round-off.

    Parameters
    ----------
    M : mass matrix (n, n)
    f : forces (n,)
    Phi_q : constraint Jacobian (n_c, n)
    gamma : right-hand sides of the constraints (n_c,)
    inertia_scale : typical inertia of each velocity (n,)
    redundant : number of redundant rows
    """
    n, n_c = f.shape[0], gamma.shape[0]
    root = np.sqrt(row_masses(Phi_q, inertia_scale))
    inverse_root = 1.0 / np.sqrt(inertia_scale)
    C = root.reshape(-1, 1) * Phi_q * inverse_root
    U, s, Vt = np.linalg.svd(C)
    most = min(n, n_c - redundant)
    rank = 0
    while rank < most and s[rank] > RANK_TOLERANCE * s[0]:
        rank += 1
    U1 = np.ascontiguousarray(U[:, :rank])
    V1 = np.ascontiguousarray(Vt[:rank])
    V2 = np.ascontiguousarray(Vt[rank:])
    M_scaled = inverse_root.reshape(-1, 1) * M * inverse_root
    f_scaled = inverse_root * f
    along = (U1.T @ (root * gamma)) / s[:rank]
    x = V1.T @ along
    if rank < n:
        free = np.linalg.solve(V2 @ M_scaled @ V2.T, V2 @ (f_scaled - M_scaled @ x))
        x = x + V2.T @ free
    multipliers = U1 @ ((V1 @ (f_scaled - M_scaled @ x)) / s[:rank])
    return inverse_root * x, root * multipliers
