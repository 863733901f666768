"""Inertia of the bodies in their floating frames, from their invariants.

Velocities of a body are ordered (rdot_G, w_B, qdot): velocity of the frame
origin in global components, angular velocity in body components, modal rates.
A rigid body is the case of no modes. The cost depends on the number of modes
only; sums that vanish for a body (model.pair_used) are left out.
See docs/errata.md for the signs of Eqs. (2), (7) and (12).
"""

from ..compiled import inlined, jit
from ..model import Model
from ..package.schema import Array
from ..rotations import rotation_into
from ..triple import Triple, cross3, dot3, triple, turned, turned_back
from ..workspace import Work


@inlined
def evaluate_bodies(model: Model, work: Work, y: Array) -> None:
    """Fill A, the lower triangles of M, and f of all bodies in state y.

    f holds quadratic velocity terms, gravity, elastic and damping forces; work.power the power
    of damping.

    Paper: Eq. (1), Eq. (2), Eq. (3), Eq. (4), Eq. (6), Eq. (7), with the modes of Eq. (15) and
    the signs that keep energy, momentum and angular momentum (docs/errata.md).
    """
    for i in range(model.n_body):
        m = model.n_mode[i]
        p = model.pos_start[i]
        c = model.n_pos + model.vel_start[i]
        A, M, f = work.A[i], work.M[i], work.f[i]
        rotation_into(y[p + 3 : p + 7], A)
        q, q_d = y[p + 7 : p + 7 + m], y[c + 6 : c + 6 + m]
        _moments(model, work, i, q, q_d)
        _inertia(model, work, i, A, q, q_d, triple(y[c + 3 : c + 6]), M, f)
        two = model.square_start[i]
        for k in range(m):
            spring, damping = 0.0, 0.0
            for j in range(m):
                spring += model.K_qq[two + k * m + j] * q[j]
                damping += model.D_qq[two + k * m + j] * q_d[j]
            f[6 + k] -= spring + damping
            work.power[0] -= q_d[k] * damping


@inlined
def _moments(model: Model, work: Work, i: int, q: Array, q_d: Array) -> None:
    """Fill D = sum m b_a phi_bk and R = sum m bdot_a phi_bk, rows 3 a + b, of body i."""
    m = model.n_mode[i]
    one, two = 9 * model.mode_start[i], 9 * model.square_start[i]
    for ab in range(9):
        for k in range(m):
            d, r = 0.0, 0.0
            if model.pair_used[i, ab]:
                d = model.T01[one + ab * m + k]
                row = two + (ab * m + k) * m
                for j in range(m):
                    d += model.T11[row + j] * q[j]
                    r += model.T11[row + j] * q_d[j]
            work.D[ab, k] = d
            work.R[ab, k] = r


@jit
def _axial(T: Array, k: int) -> Triple:
    """Return eps_cab T_ab,k, the vector of the antisymmetric part of T (9, m)."""
    return T[5, k] - T[7, k], T[6, k] - T[2, k], T[1, k] - T[3, k]


@inlined
def _inertia(
    model: Model,
    work: Work,
    i: int,
    A: Array,
    q: Array,
    q_d: Array,
    w: Triple,
    M: Array,
    f: Array,
) -> None:
    """Fill the lower triangle of M (6 + m, 6 + m) and f (6 + m,), stiffness left out."""
    m = model.n_mode[i]
    one, two = model.mode_start[i], model.square_start[i]
    D, R, S, B = work.D, work.R, 3 * model.mode_start[i], work.B
    mass, J_psi = model.mass[i], model.J_psi
    # B = sum m b b', P = sum m b bdot', first = sum m b
    b0, b1, b2 = triple(model.S0[i])
    d0, d1, d2 = 0.0, 0.0, 0.0
    e0, e1, e2 = 0.0, 0.0, 0.0  # J_psi qdot
    for k in range(m):
        b0 += model.S[S + k] * q[k]
        b1 += model.S[S + m + k] * q[k]
        b2 += model.S[S + 2 * m + k] * q[k]
        d0 += model.S[S + k] * q_d[k]
        d1 += model.S[S + m + k] * q_d[k]
        d2 += model.S[S + 2 * m + k] * q_d[k]
        e0 += J_psi[S + k] * q_d[k]
        e1 += J_psi[S + m + k] * q_d[k]
        e2 += J_psi[S + 2 * m + k] * q_d[k]
    first, first_d = (b0, b1, b2), (d0, d1, d2)
    P = work.P
    for a in range(3):
        for b in range(3):
            s, r = model.T00[i, a, b], 0.0
            for k in range(m):
                s += model.T01[9 * one + (3 * b + a) * m + k] * q[k] + D[3 * a + b, k] * q[k]
                r += D[3 * a + b, k] * q_d[k]
            B[a, b], P[a, b] = s, r
    trace = B[0, 0] + B[1, 1] + B[2, 2]
    trace_P = P[0, 0] + P[1, 1] + P[2, 2]
    for a in range(3):
        for b in range(a):
            M[a, b] = 0.0
            M[3 + a, 3 + b] = model.J0[i, a, b] - B[a, b]
        M[a, a] = mass
        M[3 + a, 3 + a] = model.J0[i, a, a] - B[a, a] + trace
        # column a of -A first~
        axis = (1.0 if a == 0 else 0.0, 1.0 if a == 1 else 0.0, 1.0 if a == 2 else 0.0)
        u = turned(A, cross3(axis, first))
        M[3 + a, 0], M[3 + a, 1], M[3 + a, 2] = u
    g_B = turned_back(A, triple(model.gravity_G))
    ww = dot3(w, w)
    for k in range(m):
        S_k = (model.S[S + k], model.S[S + m + k], model.S[S + 2 * m + k])
        M[6 + k, 0], M[6 + k, 1], M[6 + k, 2] = turned(A, S_k)
        c = _axial(D, k)
        M[6 + k, 3] = c[0] + J_psi[S + k]
        M[6 + k, 4] = c[1] + J_psi[S + m + k]
        M[6 + k, 5] = c[2] + J_psi[S + 2 * m + k]
        for j in range(k + 1):
            M[6 + k, 6 + j] = model.M_qq[two + k * m + j]
        f_k = dot3(S_k, g_B) - 2.0 * dot3(w, _axial(R, k))
        for a in range(3):
            f_k += ww * D[4 * a, k]
            for b in range(3):
                f_k -= w[a] * w[b] * D[3 * a + b, k]
        f[6 + k] = f_k
    arm = cross3(first, g_B)
    # J w + J_psi qdot, with the symmetric J from its lower triangle
    h0 = M[3, 3] * w[0] + M[4, 3] * w[1] + M[5, 3] * w[2] + e0
    h1 = M[4, 3] * w[0] + M[4, 4] * w[1] + M[5, 4] * w[2] + e1
    h2 = M[5, 3] * w[0] + M[5, 4] * w[1] + M[5, 5] * w[2] + e2
    spin = cross3(w, (h0, h1, h2))
    coriolis = turned_back(P, w)
    u, v = cross3(w, cross3(w, first)), cross3(w, first_d)
    s_r = turned(A, (u[0] + 2.0 * v[0], u[1] + 2.0 * v[1], u[2] + 2.0 * v[2]))
    for a in range(3):
        f[a] = mass * model.gravity_G[a] - s_r[a]
        f[3 + a] = arm[a] - spin[a] + 2.0 * (coriolis[a] - trace_P * w[a])


@jit
def centrifugal_matrix(w: Array, T11: Array, m: int) -> Array:
    """Return w_a w_b sum m (delta_ab phi_i.phi_j - phi_ia phi_jb), (m, m) [kg m2/s2].

    The stiffness that spinning takes from the modes of a linear body. `T11` is
    laid out as in `Model`.
    """
    T = T11.reshape(3, 3, m, m)
    out = (w @ w) * (T[0, 0] + T[1, 1] + T[2, 2])
    for a in range(3):
        for b in range(3):
            out = out - w[a] * w[b] * T[a, b]
    return 0.5 * (out + out.T)
