"""The augmented Lagrangian of Bayo: a penalty method with iterated multipliers."""

import numpy as np

from ....math.arrays import Array
from .treatment import row_masses


def augmented_lagrangian(
    M: Array,
    f: Array,
    Phi_q: Array,
    gamma: Array,
    inertia_scale: Array,
    penalty: float,
    tolerance: float,
    max_iterations: int,
) -> tuple[Array, Array]:
    """Return accelerations (n,) and multipliers (n_c,) by iteration of the multipliers.

    (M + Phi_q' P Phi_q) a_i+1 = f + Phi_q' (P gamma - lambda_i),
    lambda_i+1 = lambda_i + P (Phi_q a_i+1 - gamma),  from lambda_0 = 0,

    with P = `penalty` times the mass that each row moves, and the feedback 2 xi W Phidot +
    W^2 Phi in gamma. The matrix is positive definite for any rank of Phi_q. An error
    decreases by the factor 1 + penalty sigma^2 in each iteration, with a singular value sigma of
    the scaled Jacobian. Redundant rows have no effect, and in a singular position the rows with
    sigma = 0 are not enforced. The multipliers have least norm, because they are sums of P Phi_q a.

    The iteration uses corrections by the residuals of both equations, which also removes the
    round-off of a large penalty. It ends when a correction is below `tolerance` of the
    accelerations.

    Parameters
    ----------
    M : mass matrix (n, n)
    f : forces (n,)
    Phi_q : constraint Jacobian (n_c, n)
    gamma : right-hand sides of the constraints (n_c,)
    inertia_scale : typical inertia of each velocity (n,)
    penalty : penalty over the mass that a row moves
    tolerance : largest last correction, relative to the accelerations
    max_iterations : number of iterations after which it ends
    """
    n, n_c = f.shape[0], gamma.shape[0]
    P = penalty * row_masses(Phi_q, inertia_scale)
    transposed = np.ascontiguousarray(Phi_q.T)
    inverse = np.linalg.inv(M + transposed @ (P.reshape(-1, 1) * Phi_q))
    a, multipliers = np.zeros(n), np.zeros(n_c)
    unbalanced, open_gamma = f.copy(), gamma.copy()
    for _ in range(max_iterations):
        correction = inverse @ (unbalanced + transposed @ (P * open_gamma))
        a += correction
        multipliers += P * (Phi_q @ correction - open_gamma)
        open_gamma = gamma - Phi_q @ a
        unbalanced = f - M @ a - transposed @ multipliers
        size = np.sum(inertia_scale * correction * correction)
        if size <= tolerance * tolerance * np.sum(inertia_scale * a * a):
            break
    return a, multipliers
