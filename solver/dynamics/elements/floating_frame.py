"""Equations of one body in its floating frame, from its inertia invariants.

Velocities of a body are ordered (rdot_G, w_B, qdot): velocity of the frame
origin in global components, angular velocity in body components, modal rates.
A rigid body has no modes. The cost depends only on the number of modes;
zero sums of a body (model.pair_used) are skipped.
See docs/errata.md for the signs of Eqs. (2), (7) and (12).

Second-order displacements of stiffened bodies (geometric stiffening) follow below, with vectors
by bodies and their products with the constraint Jacobian.
"""

import numpy as np

from ...math.arrays import Array, Triple, quadratic_forms
from ...math.compiled import COMPILED, inlined, jit, lean
from ...math.rotations import (
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
from ..model.model import Model, Workspace
from ..model.motion import bend_marker, contract


@inlined
def row_products(model: Model, J: Array, a: Array, out: Array) -> None:
    """Fill out (n_c,) with Phi_q a, for J (nb, n, r) and a (nb, n).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    J : Jacobians by bodies (nb, n, r)
    a : velocities or accelerations by bodies (nb, n)
    out : products (n_c,), to fill
    """
    layout = model.layout
    out[:] = 0.0
    for i in range(layout.size.shape[0]):
        first = layout.row_start[i]
        for p in range(layout.row_start[i + 1] - first):
            row = layout.body_row[first + p]
            for j in range(layout.size[i]):
                out[row] += J[i, j, p] * a[i, j]


@inlined
def flatten(model: Model, x: Array, out: Array, first: int) -> None:
    """Fill out from `first` on with x (nb, n), body after body: n_vel numbers.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    x : numbers by bodies (nb, n)
    out : array to fill
    first : place of the first of n_vel numbers
    """
    for i in range(model.n_body):
        j = first + model.vel_start[i]
        for k in range(model.layout.size[i]):
            out[j + k] = x[i, k]


@inlined
def inflate(model: Model, a: Array, first: int, x: Array) -> None:
    """Fill x (nb, n) with n_vel numbers of a, from `first` on.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    a : array with n_vel numbers
    first : place of the first one
    x : numbers by bodies (nb, n), to fill
    """
    for i in range(model.n_body):
        j = first + model.vel_start[i]
        for k in range(model.layout.size[i]):
            x[i, k] = a[j + k]


@lean
def largest(a: Array) -> float:
    """Return the largest absolute value of a; nan if there is one."""
    most = 0.0
    for x in a:
        if abs(x) > most or x != x:
            most = abs(x)
    return most


@lean
def _looped_add_elastic(
    M: Array, f: Array, q: Array, q_d: Array, G3: Array, three: int, G4: Array, four: int
) -> None:
    m = q.shape[0]
    for i in range(m):
        f_i = 0.0
        for j in range(m):
            # E_i,jl is symmetric in j and l: each pair once
            for k in range(j, m):
                row = four + ((i * m + j) * m + k) * m
                e = G3[three + (i * m + j) * m + k]
                for n in range(m):
                    e += G4[row + n] * q[n]
                if j <= i:
                    M[6 + i, 6 + j] += e * q[k]
                f_i += e * q_d[j] * q_d[k]
                if k != j:
                    if k <= i:
                        M[6 + i, 6 + k] += e * q[j]
                    f_i += e * q_d[j] * q_d[k]
            if j <= i:
                s = 0.0
                for k in range(m):
                    s += G3[three + (j * m + i) * m + k] * q[k]
                M[6 + i, 6 + j] += s
        f[6 + i] -= f_i


def _add_elastic(
    M: Array, f: Array, q: Array, q_d: Array, G3: Array, three: int, G4: Array, four: int
) -> None:
    """Add the modal mass of the deformed body to M's lower triangle, and its velocity terms to f.

    With E_i,jl = G3_i,jl + G4_ik,jl q_k = sum m (db/dq_i) . h_jl:
    M_ij += E_i,jl q_l + G3_j,ik q_k and f_i -= E_i,jl q_d_j q_d_l.

    Parameters
    ----------
    M : (6 + m, 6 + m); f : (6 + m,); q, q_d : (m,)
    G3, G4 : flat as in `Model`, from `three` and `four` on
    """
    m = q.shape[0]
    G = G3[three : three + m**3].reshape(m, m, m)
    E = G + (G4[four : four + m**4].reshape(m**3, m) @ q).reshape(m, m, m)
    M[6 : 6 + m, 6 : 6 + m] += E @ q + (G @ q).T
    f[6 : 6 + m] -= (E @ q_d) @ q_d


# Without Numba, four nested loops would take most of the time.
add_elastic = _looped_add_elastic if COMPILED else _add_elastic


@inlined
def add_moments(model: Model, work: Workspace, i: int, q: Array, q_d: Array) -> None:
    """Add the second-order terms to the moments of body i, which have the linear terms.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    i : number of the body
    q : its modal coordinates (m,)
    q_d : their rates (m,) [1/s]
    """
    m = model.n_mode[i]
    first, B, P, twist = work.first, work.B, work.P, work.twist
    for row in range(12):
        if model.Z_used[i, row]:
            start = 12 * model.second_start[i] + row * m * m
            slope = work.C[row] if row < 3 else work.D[row - 3]
            by_q, mixed, by_q_d = contract(model.Z, start, q, q_d, slope)
            if row < 3:
                first[0, row] += 0.5 * by_q
                first[1, row] += mixed
                first[2, row] += by_q_d
            else:
                a, b = (row - 3) // 3, (row - 3) % 3
                B[a, b] += 0.5 * by_q
                B[b, a] += 0.5 * by_q
                P[a, b] += mixed
                if b != a:
                    twist[3 - a - b] += by_q_d if b == (a + 1) % 3 else -by_q_d


@inlined
def add_carried(model: Model, work: Workspace, i: int, q: Array, q_d: Array) -> None:
    """Add terms of point masses and pieces that `add_moments` neglects to the moments of body i.

    The position of a point is x + u + e, u = phi q, e = 1/2 q' H q. The previous sums contain its
    mass without u e', e u' and e e'. Pieces of a body add the antisymmetric parts alone, the moment
    of momentum of the modes: in the symmetric ones, of the inertia, displacements of third order
    count as much, which are neglected (docs/adr/0080).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    i : number of the body
    q : its modal coordinates (m,)
    q_d : their rates (m,) [1/s]
    """
    m = model.n_mode[i]
    D, R, B, P = work.D, work.R, work.B, work.P
    for p in range(model.carried_start[i], model.carried_start[i + 1]):
        k, mass = model.carried_marker[p], model.carried_mass[p]
        complete = mass if model.carried_whole[p] else 0.0
        one, other = 0.5 * (mass + complete), 0.5 * (mass - complete)
        J_m, s = work.J_m[k], model.marker_start[k]
        e, e_d, e_dd = bend_marker(
            model.marker_H, model.marker_second[k], model.marker_H_used[k], 0, q, q_d, J_m
        )
        u = (0.0, 0.0, 0.0)
        u_d = (0.0, 0.0, 0.0)
        for n in range(m):
            phi = _shape(model, s, m, n)
            u, u_d = sum3(u, times3(q[n], phi)), sum3(u_d, times3(q_d[n], phi))
        turn = cross3(sum3(u, e), e_dd)
        for a in range(3):
            work.twist[a] += mass * turn[a]
            for b in range(3):
                B[a, b] += complete * (u[a] * e[b] + e[a] * (u[b] + e[b]))
                moved = u[a] * e_d[b] + e[a] * (u_d[b] + e_d[b])
                P[a, b] += one * moved
                P[b, a] -= other * moved
        for n in range(m):
            slope = column(J_m, 6 + n)
            whole = sum3(_shape(model, s, m, n), slope)
            for a in range(3):
                for b in range(3):
                    d = u[a] * slope[b] + e[a] * whole[b]
                    r = u_d[a] * slope[b] + e_d[a] * whole[b]
                    D[3 * a + b, n] += one * d
                    D[3 * b + a, n] -= other * d
                    R[3 * a + b, n] += one * r
                    R[3 * b + a, n] -= other * r


@inlined
def _shape(model: Model, s: int, m: int, n: int) -> Triple:
    """Return the translation of a marker per unit of mode n; its m modes begin at s."""
    return (
        model.marker_phi[s + n],
        model.marker_phi[s + m + n],
        model.marker_phi[s + 2 * m + n],
    )


@inlined
def add_modal_inertia(model: Model, work: Workspace, i: int, q: Array, q_d: Array) -> None:
    """Add the second-order terms to M_qq and f of body i, which have the linear terms.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    i : number of the body
    q : its modal coordinates (m,)
    q_d : their rates (m,) [1/s]
    """
    three, four = model.third_start[i], model.fourth_start[i]
    add_elastic(work.M[i], work.f[i], q, q_d, model.G3, three, model.G4, four)


def second_order_first_moment(model: Model, i: int, q: Array) -> Array:
    """Return the second-order terms of sum m b of stiffened body i, 1/2 q Z0 q, (k, 3) [kg m].

    q (k, m) are its modal coordinates.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    i : number of the body
    q : its modal coordinates (k, m)
    """
    return 0.5 * quadratic_forms(_distances(model, i)[:3], q)


def _distances(model: Model, i: int) -> Array:
    """Return Z0 and Z1 of stiffened body i, (12, m, m)."""
    m, two = int(model.n_mode[i]), int(model.second_start[i])
    return model.Z[12 * two : 12 * (two + m * m)].reshape(12, m, m)


def stiffening_matrices(
    model: Model, i: int, w: Array, w_d: Array, a_B: Array, q_dd: Array
) -> Array:
    """Return the geometric stiffness of stiffened body i's own inertia loads, (k, m, m) [N m].

    The derivative of the elastic forces by q at constant accelerations: positive in tension,
    negative in compression.

    Parameters
    ----------
    w, w_d : (k, 3) spin and its rate, body components
    a_B : (k, 3) acceleration of the frame origin minus gravity, body components [m/s2]
    q_dd : (k, m) modal accelerations
    """
    m = int(model.n_mode[i])
    three = int(model.third_start[i])
    Z, G3 = _distances(model, i).reshape(12, m * m), model.G3[three : three + m**3]
    # acceleration of a station due to its position: w_d x x + w x (w x x)
    turning = np.zeros((len(w), 3, 3))
    turning[:, [2, 0, 1], [1, 2, 0]] = w_d
    turning[:, [1, 2, 0], [2, 0, 1]] = -w_d
    turning += w[:, :, None] * w[:, None, :]
    turning -= np.einsum("ka,ka->k", w, w)[:, None, None] * np.eye(3)
    turned = turning.transpose(0, 2, 1).reshape(-1, 9)
    Kg = a_B @ Z[:3] + turned @ Z[3:] + q_dd @ G3.reshape(m, m * m)
    return np.asarray(Kg.reshape(-1, m, m))


@inlined
def evaluate_bodies(model: Model, work: Workspace, y: Array) -> None:
    """Fill A, the lower triangles of M, and f of all bodies in state y.

    f has quadratic velocity terms, gravity, elastic and damping forces; work.power has the power
    of damping.

    Paper: Eq. (1), Eq. (2), Eq. (3), Eq. (4), Eq. (6), Eq. (7), with the modes of Eq. (15) and
    the signs that keep energy, momentum and angular momentum (docs/errata.md).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    """
    for i in range(model.n_body):
        m = model.n_mode[i]
        p = model.pos_start[i]
        c = model.n_pos + model.vel_start[i]
        f = work.f[i]
        rotation_into(y[p + 3 : p + 7], work.A[i])
        q, q_d = y[p + 7 : p + 7 + m], y[c + 6 : c + 6 + m]
        stiffened = model.second_start[i + 1] > model.second_start[i]
        _moments(model, work, i, q, q_d)
        if stiffened:
            add_moments(model, work, i, q, q_d)
            add_carried(model, work, i, q, q_d)
        _inertia(model, work, i, q_d, triple(y[c + 3 : c + 6]))
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
def _moments(model: Model, work: Workspace, i: int, q: Array, q_d: Array) -> None:
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
def _inertia(model: Model, work: Workspace, i: int, q_d: Array, w: Triple) -> None:
    """Fill the lower triangle of M (6 + m, 6 + m) and f (6 + m,) of body i, without stiffness."""
    m, A, M, f = model.n_mode[i], work.A[i], work.M[i], work.f[i]
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
