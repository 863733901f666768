"""Order of the degrees of freedom of a shell element, and its rotation to the axes of G."""

import numpy as np

from ...solver.math.arrays import Array

# Positions in the six degrees of freedom (u, v, w, rx, ry, rz) of a corner: by = -rx, bx = ry.
MEMBRANE, PLATE = (0, 1, 5), (2, 4, 3)
SIGN = (1.0, 1.0, -1.0)  # signs of the plate's degrees of freedom


def together(K_m: Array, K_b: Array, K_mb: Array | None) -> Array:
    """Matrix of all degrees of freedom (u, v, w, rx, ry, rz) of k corners in E, (c, 6 k, 6 k).

    Parameters
    ----------
    K_m, K_b, K_mb : (c, 3 k, 3 k) of the membrane, of the plate, and rows of the membrane with
        columns of the plate
    """
    k = K_m.shape[1] // 3
    K = np.zeros((len(K_m), k, 6, k, 6))
    m, b = K_m.reshape(-1, k, 3, k, 3), K_b.reshape(-1, k, 3, k, 3)
    mb = None if K_mb is None else K_mb.reshape(-1, k, 3, k, 3)
    for i in range(3):
        for j in range(3):
            K[:, :, MEMBRANE[i], :, MEMBRANE[j]] = m[:, :, i, :, j]
            sign = SIGN[i] * SIGN[j]
            K[:, :, PLATE[i], :, PLATE[j]] = sign * b[:, :, i, :, j]
            if mb is not None:
                K[:, :, MEMBRANE[i], :, PLATE[j]] = SIGN[j] * mb[:, :, i, :, j]
                K[:, :, PLATE[j], :, MEMBRANE[i]] = SIGN[j] * mb[:, :, i, :, j].swapaxes(1, 2)
    return K.reshape(-1, 6 * k, 6 * k)


def to_G(A_GE: Array, K_E: Array) -> Array:
    """Rotate a symmetric matrix (c, n, n) from E to G: R K R', R with A_GE on its diagonal.

    Paper: Eq. (23).
    """
    A_EG = np.swapaxes(A_GE, 1, 2)
    n = K_E.shape[1]
    right = (K_E.reshape(-1, n * n // 3, 3) @ A_EG).reshape(-1, n, n)
    left = np.ascontiguousarray(np.swapaxes(right, 1, 2))  # K is symmetric: R K
    return np.asarray((left.reshape(-1, n * n // 3, 3) @ A_EG).reshape(-1, n, n))


def own_displacements(A_GE: Array, u_G: Array) -> tuple[Array, Array]:
    """Degrees of freedom of the membrane and of the plate in E, each (c, 3 k, m).

    Paper: Eq. (23).

    Parameters
    ----------
    u_G : (c, 6 k, m) of the k corners in G
    """
    c, n, m = u_G.shape
    u_E = np.swapaxes(A_GE, 1, 2)[:, None] @ u_G.reshape(c, n // 3, 3, m)
    u = u_E.reshape(c, n // 6, 6, m)
    u_m = u[:, :, MEMBRANE]
    u_b = u[:, :, PLATE] * np.array(SIGN)[:, None]
    return u_m.reshape(c, n // 2, m), u_b.reshape(c, n // 2, m)
