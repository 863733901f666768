"""Inertia of the bodies in their floating frames, from their invariants.

Velocities of a body are ordered (rdot_G, w_B, qdot): velocity of the frame
origin in global components, angular velocity in body components, modal rates.
A rigid body has no modes. The cost depends only on the number of modes;
zero sums of a body (model.pair_used) are skipped.
See docs/errata.md for the signs of Eqs. (2), (7) and (12).
"""

from ....math.arrays import Array
from ....math.compiled import inlined, jit
from ....math.rotations import (
    Triple,
    column,
    cross3,
    dot3,
    rotation_into,
    sum3,
    times3,
    triple,
    turned,
    turned_back,
)
from ...model.model import Model
from ...model.workspace import Work
from .second_order import add_carried, add_modal_inertia, add_moments


@inlined
def evaluate_bodies(model: Model, work: Work, y: Array) -> None:
    """Fill A, the lower triangles of M, and f of all bodies in state y.

    f has quadratic velocity terms, gravity, elastic and damping forces; work.power has the power
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
        stiffened = model.second_start[i + 1] > model.second_start[i]
        _moments(model, work, i, q, q_d)
        if stiffened:
            add_moments(model, work, i, q, q_d)
            add_carried(model, work, i, q, q_d)
        _inertia(model, work, i, A, q_d, triple(y[c + 3 : c + 6]), M, f)
        if stiffened:
            add_modal_inertia(model, work, i, q, q_d)
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
    """Fill the moments of mass of body i, with linear displacements, for `_inertia`.

    D = sum m b_a phi_bk and R = sum m bdot_a phi_bk, rows 3 a + b; B = sum m b b',
    P = sum m b bdot'; the first moment, sum m b, its rates, and its slope C = sum m phi.
    """
    m = model.n_mode[i]
    one, two = 9 * model.mode_start[i], 9 * model.square_start[i]
    D, S, first = work.D, 3 * model.mode_start[i], work.first
    for ab in range(9):
        for k in range(m):
            d, r = 0.0, 0.0
            if model.pair_used[i, ab]:
                d = model.T01[one + ab * m + k]
                row = two + (ab * m + k) * m
                for j in range(m):
                    d += model.T11[row + j] * q[j]
                    r += model.T11[row + j] * q_d[j]
            D[ab, k] = d
            work.R[ab, k] = r
    for a in range(3):
        moment, rate = model.S0[i, a], 0.0
        for k in range(m):
            c = model.S[S + a * m + k]
            work.C[a, k] = c
            moment += c * q[k]
            rate += c * q_d[k]
        first[0, a], first[1, a], first[2, a] = moment, rate, 0.0
        work.twist[a] = 0.0
        for b in range(3):
            s, r = model.T00[i, a, b], 0.0
            for k in range(m):
                s += model.T01[one + (3 * b + a) * m + k] * q[k] + D[3 * a + b, k] * q[k]
                r += D[3 * a + b, k] * q_d[k]
            work.B[a, b], work.P[a, b] = s, r


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
    q_d: Array,
    w: Triple,
    M: Array,
    f: Array,
) -> None:
    """Fill the lower triangle of M (6 + m, 6 + m) and f (6 + m,), without stiffness."""
    m = model.n_mode[i]
    two, S = model.square_start[i], 3 * model.mode_start[i]
    D, R, C, B, P = work.D, work.R, work.C, work.B, work.P
    mass, J_psi = model.mass[i], model.J_psi
    first, first_d, first_dd = triple(work.first[0]), triple(work.first[1]), triple(work.first[2])
    e0, e1, e2 = 0.0, 0.0, 0.0  # J_psi qdot
    for k in range(m):
        e0 += J_psi[S + k] * q_d[k]
        e1 += J_psi[S + m + k] * q_d[k]
        e2 += J_psi[S + 2 * m + k] * q_d[k]
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
        C_k = column(C, k)
        M[6 + k, 0], M[6 + k, 1], M[6 + k, 2] = turned(A, C_k)
        c = _axial(D, k)
        M[6 + k, 3] = c[0] + J_psi[S + k]
        M[6 + k, 4] = c[1] + J_psi[S + m + k]
        M[6 + k, 5] = c[2] + J_psi[S + 2 * m + k]
        for j in range(k + 1):
            M[6 + k, 6 + j] = model.M_qq[two + k * m + j]
        f_k = dot3(C_k, g_B) - 2.0 * dot3(w, _axial(R, k))
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
    s_r = sum3(u, sum3(times3(2.0, v), first_dd))
    s_r = turned(A, s_r)
    for a in range(3):
        f[a] = mass * model.gravity_G[a] - s_r[a]
        f[3 + a] = arm[a] - spin[a] + 2.0 * (coriolis[a] - trace_P * w[a]) - work.twist[a]


def centrifugal_matrix(w: Array, T11: Array, m: int) -> Array:
    """Return w_a w_b sum m (delta_ab phi_i.phi_j - phi_ia phi_jb), (m, m) [kg m2/s2].

    The reduction of modal stiffness by the spin of a linear body. `T11` is
    laid out as in `Model`.
    """
    T = T11.reshape(3, 3, m, m)
    out = (w @ w) * (T[0, 0] + T[1, 1] + T[2, 2])
    for a in range(3):
        for b in range(3):
            out = out - w[a] * w[b] * T[a, b]
    return 0.5 * (out + out.T)
