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
from ..small import add, add_transposed, mm, mv, tv


@jit
def axial(T: Array) -> Array:
    """Return eps_cab T_abi, (3, m): the vector of the antisymmetric part of (3, 3, m)."""
    out = np.empty((3, T.shape[2]))
    for k in range(T.shape[2]):
        out[0, k] = T[1, 2, k] - T[2, 1, k]
        out[1, k] = T[2, 0, k] - T[0, 2, k]
        out[2, k] = T[0, 1, k] - T[1, 0, k]
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
    axial_R = axial(mv(T11, q_d).reshape(3, 3, m))  # eps_cab sum m bdot_a phi_bi
    D_flat = D.reshape(9, m)
    B = T00 + T01_q.T + mv(D_flat, q).reshape(3, 3)  # sum m b_a b_b
    P = mv(D_flat, q_d).reshape(3, 3)  # sum m b_a bdot_b
    first = S0 + mv(S, q)
    first_d = mv(S, q_d)
    trace = B[0, 0] + B[1, 1] + B[2, 2]
    A_S = mm(A_GB, S)
    A_first = mm(A_GB, skew(first))
    M_wq = axial(D)
    add(M_wq, 0, 0, J_psi, 1.0)
    J = J0 - B
    for i in range(3):
        M[i, i] += mass
        J[i, i] += trace
    add(M, 0, 3, A_first, -1.0)
    add_transposed(M, 3, 0, A_first, -1.0)
    add(M, 3, 3, J, 1.0)
    add(M, 0, 6, A_S, 1.0)
    add_transposed(M, 6, 0, A_S, 1.0)
    add(M, 3, 6, M_wq, 1.0)
    add_transposed(M, 6, 3, M_wq, 1.0)
    add(M, 6, 6, M_qq, 1.0)

    g_B = tv(A_GB, gravity_G)
    s_r = mv(A_GB, cross(w, cross(w, first)) + 2.0 * cross(w, first_d))
    weight = cross(first, g_B)
    spin = cross(w, mv(J, w) + mv(J_psi, q_d))
    coriolis = tv(P, w)
    trace_P = P[0, 0] + P[1, 1] + P[2, 2]
    for i in range(3):
        f[i] += mass * gravity_G[i] - s_r[i]
        f[3 + i] += weight[i] - spin[i] + 2.0 * (coriolis[i] - trace_P * w[i])
    modal_weight = tv(S, g_B)
    ww = dot(w, w)
    for k in range(m):
        f_k = modal_weight[k]
        for a in range(3):
            f_k += ww * D[a, a, k] - 2.0 * w[a] * axial_R[a, k]
            for b in range(3):
                f_k -= w[a] * w[b] * D[a, b, k]
        f[6 + k] += f_k


@jit
def centrifugal_matrix(w: Array, T11: Array, m: int) -> Array:
    """Return w_a w_b sum m (delta_ab phi_i.phi_j - phi_ia phi_jb), (m, m) [kg m2/s2].

    The stiffness that spinning takes from the modes of a linear body. `T11` is
    laid out as in `add_inertia`.
    """
    T = T11.reshape(3, 3, m, m)
    out = dot(w, w) * (T[0, 0] + T[1, 1] + T[2, 2])
    for a in range(3):
        for b in range(3):
            out = out - w[a] * w[b] * T[a, b]
    return 0.5 * (out + out.T)
