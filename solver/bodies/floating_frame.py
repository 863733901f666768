"""Inertia of one body in a floating frame, from its invariants.

Velocities of a body are ordered (rdot_G, w_B, qdot): velocity of the frame
origin in global components, angular velocity in body components, modal rates.
A rigid body is the case of no modes. The cost depends on the number of modes
only. See docs/errata.md for the signs of Eqs. (2), (7) and (12).
"""

import numpy as np

from ..compiled import jit
from ..package.schema import Array
from ..rotations import cross, dot, skew
from ..small import mm, mv, tv


@jit
def axial(T: Array) -> Array:
    """Return eps_cab T_abi, (3, m): the vector of the antisymmetric part of (3, 3, m)."""
    out = np.empty((3, T.shape[2]))
    out[0] = T[1, 2] - T[2, 1]
    out[1] = T[2, 0] - T[0, 2]
    out[2] = T[0, 1] - T[1, 0]
    return out


@jit
def add_inertia(
    M: Array,
    f: Array,
    A_GB: Array,
    w: Array,
    q: Array,
    q_d: Array,
    gravity_G: Array,
    mass: float,
    S0: Array,
    S: Array,
    T00: Array,
    T01: Array,
    T11: Array,
    J0: Array,
    J_psi: Array,
    M_qq: Array,
) -> None:
    """Add mass matrix, quadratic velocity terms and gravity of one body to M and f.

    Paper: Eq. (1), Eq. (2), Eq. (7), with the modes of Eq. (15) and the signs
    that keep energy, momentum and angular momentum (docs/errata.md).

    Parameters
    ----------
    M : (6 + m, 6 + m), f : (6 + m,)
        The body's blocks, added to in place.
    A_GB : (3, 3); w : (3,) body components [rad/s]; q, q_d : (m,)
    gravity_G : (3,) [m/s2]
    mass, S0, S, T00, T01 (9, m), T11 (9 m, m), J0, J_psi, M_qq
        Invariants (package/schema.py). T11 rows run over (a, b, i) and columns
        over j: sum m phi_aj phi_bi, so that one product contracts the first shape.
    """
    m = q.shape[0]
    T01_q = mv(T01, q).reshape(3, 3)
    D = (T01.reshape(9 * m) + mv(T11, q)).reshape(3, 3, m)  # sum m b_a phi_bi
    R = mv(T11, q_d).reshape(3, 3, m)  # sum m bdot_a phi_bi
    D_flat = D.reshape(9, m)
    B = T00 + T01_q.T + mv(D_flat, q).reshape(3, 3)  # sum m b_a b_b
    P = mv(D_flat, q_d).reshape(3, 3)  # sum m b_a bdot_b
    first = S0 + mv(S, q)
    first_d = mv(S, q_d)
    J = (B[0, 0] + B[1, 1] + B[2, 2]) * np.eye(3) - B + J0
    M_wq = axial(D) + J_psi
    A_S = mm(A_GB, S)
    A_first = mm(A_GB, skew(first))

    for i in range(3):
        M[i, i] += mass
    M[0:3, 3:6] -= A_first
    M[3:6, 0:3] -= A_first.T
    M[3:6, 3:6] += J
    M[0:3, 6:] += A_S
    M[6:, 0:3] += A_S.T
    M[3:6, 6:] += M_wq
    M[6:, 3:6] += M_wq.T
    M[6:, 6:] += M_qq

    g_B = tv(A_GB, gravity_G)
    f[0:3] += mass * gravity_G - mv(A_GB, cross(w, cross(w, first)) + 2.0 * cross(w, first_d))
    f[3:6] += (
        cross(first, g_B)
        - cross(w, mv(J, w) + mv(J_psi, q_d))
        + 2.0 * (tv(P, w) - (P[0, 0] + P[1, 1] + P[2, 2]) * w)
    )
    ww = np.outer(w, w).reshape(9)
    f[6:] += (
        tv(S, g_B)
        + dot(w, w) * (D[0, 0] + D[1, 1] + D[2, 2])
        - tv(D_flat, ww)
        - 2.0 * tv(axial(R), w)
    )


@jit
def centrifugal_matrix(w: Array, T11: Array, m: int) -> Array:
    """Return w_a w_b sum m (delta_ab phi_i.phi_j - phi_ia phi_jb), (m, m) [1/s2 kg].

    The stiffness that spinning takes from the modes of a linear body. `T11` is
    laid out as in `add_inertia`.
    """
    T = T11.reshape(3, 3, m, m)
    out = dot(w, w) * (T[0, 0] + T[1, 1] + T[2, 2])
    for a in range(3):
        for b in range(3):
            out = out - w[a] * w[b] * T[a, b]
    return 0.5 * (out + out.T)
