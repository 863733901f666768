"""Accelerations and multipliers from one linear system, for independent constraints."""

import numpy as np

from ....math.arrays import Array


def saddle_point(M: Array, f: Array, Phi_q: Array, gamma: Array) -> tuple[Array, Array]:
    """Return accelerations (n,) and multipliers (n_c,). Paper: Eq. (12), Eq. (14), Eq. (16).

    [M Phi_q'; Phi_q 0] [a; lambda] = [f; gamma]; a load Lambda w, not
    Lambda u' (docs/errata.md), is part of f.

    Parameters
    ----------
    M : mass matrix (n, n)
    f : forces (n,)
    Phi_q : constraint Jacobian (n_c, n)
    gamma : right-hand sides of the constraints (n_c,)

    Raises
    ------
    numpy.linalg.LinAlgError
        If the matrix is exactly singular.
    """
    n = f.shape[0]
    n_c = gamma.shape[0]
    A = np.zeros((n + n_c, n + n_c))
    A[:n, :n] = M
    A[n:, :n] = Phi_q
    A[:n, n:] = Phi_q.T
    b = np.empty(n + n_c)
    b[:n] = f
    b[n:] = gamma
    x = np.linalg.solve(A, b)
    return x[:n], x[n:]
