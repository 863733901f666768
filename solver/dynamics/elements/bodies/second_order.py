"""Geometric stiffening: second-order displacements of a floating body."""

import numpy as np

from ....math.arrays import Array
from ....math.compiled import COMPILED, inlined, lean
from ....math.rotations import Triple, column, cross3, sum3, times3
from ...model.model import Model
from ...model.workspace import Work


@lean
def contract(T: Array, start: int, q: Array, q_d: Array, slope: Array) -> Triple:
    """Contract a table symmetric in two modes: return q T q, q T q_d, q_d T q_d.

    Parameters
    ----------
    T : flat, the table (m, m) from `start` on
    q, q_d : (m,)
    slope : (m,) gets T q added
    """
    by_q, mixed, by_q_d = 0.0, 0.0, 0.0
    row = start
    for i in range(q.shape[0]):
        one, two = 0.0, 0.0
        for j in range(q.shape[0]):
            one += T[row + j] * q[j]
            two += T[row + j] * q_d[j]
        row += q.shape[0]
        slope[i] += one
        by_q += one * q[i]
        mixed += one * q_d[i]
        by_q_d += two * q_d[i]
    return by_q, mixed, by_q_d


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
def add_moments(model: Model, work: Work, i: int, q: Array, q_d: Array) -> None:
    """Add the second-order terms to the moments of body i, which have the linear terms."""
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
def add_carried(model: Model, work: Work, i: int, q: Array, q_d: Array) -> None:
    """Add the terms of point masses to the moments of body i that `add_moments` neglects.

    The position of a point is x + u + e, u = phi q, e = 1/2 q' H q. The previous sums contain its
    mass without u e', e u' and e e'.
    """
    m = model.n_mode[i]
    D, R, B, P = work.D, work.R, work.B, work.P
    for p in range(model.carried_start[i], model.carried_start[i + 1]):
        k, mass = model.carried_marker[p], model.carried_mass[p]
        J_m, s = work.J_m[k], model.marker_start[k]
        e, e_d, e_dd = bend_marker(model, k, 0, q, q_d, J_m)
        u = (0.0, 0.0, 0.0)
        u_d = (0.0, 0.0, 0.0)
        for n in range(m):
            phi = _shape(model, s, m, n)
            u, u_d = sum3(u, times3(q[n], phi)), sum3(u_d, times3(q_d[n], phi))
        turn = cross3(sum3(u, e), e_dd)
        for a in range(3):
            work.twist[a] += mass * turn[a]
            for b in range(3):
                B[a, b] += mass * (u[a] * e[b] + e[a] * (u[b] + e[b]))
                P[a, b] += mass * (u[a] * e_d[b] + e[a] * (u_d[b] + e_d[b]))
        for n in range(m):
            slope = column(J_m, 6 + n)
            whole = sum3(_shape(model, s, m, n), slope)
            for a in range(3):
                for b in range(3):
                    D[3 * a + b, n] += mass * (u[a] * slope[b] + e[a] * whole[b])
                    R[3 * a + b, n] += mass * (u_d[a] * slope[b] + e_d[a] * whole[b])


@inlined
def _shape(model: Model, s: int, m: int, n: int) -> Triple:
    """Return the translation of a marker per unit of mode n; its m modes begin at s."""
    return (
        model.marker_phi[s + n],
        model.marker_phi[s + m + n],
        model.marker_phi[s + 2 * m + n],
    )


@inlined
def add_modal_inertia(model: Model, work: Work, i: int, q: Array, q_d: Array) -> None:
    """Add the second-order terms to M_qq and f of body i, which have the linear terms."""
    three, four = model.third_start[i], model.fourth_start[i]
    add_elastic(work.M[i], work.f[i], q, q_d, model.G3, three, model.G4, four)


@inlined
def bend_marker(
    model: Model, k: int, row: int, q: Array, q_d: Array, J_m: Array
) -> tuple[Triple, Triple, Triple]:
    """Return the second-order terms of a vector of marker k and of its rates.

    1/2 q' H q, q' H q_d and q_d' H q_d of the translation (`row` 0) or of the rotation vector
    (`row` 3), body components. The columns of the modes in J_m (6, n) become H q there.
    """
    m = q.shape[0]
    h = model.marker_second[k] + row * m * m
    used = model.marker_H_used[k]
    x = y = z = (0.0, 0.0, 0.0)
    for a in range(row, row + 3):
        for n in range(6, 6 + m):
            J_m[a, n] = 0.0
    if used[row]:
        x = contract(model.marker_H, h, q, q_d, J_m[row, 6 : 6 + m])
    if used[row + 1]:
        y = contract(model.marker_H, h + m * m, q, q_d, J_m[row + 1, 6 : 6 + m])
    if used[row + 2]:
        z = contract(model.marker_H, h + 2 * m * m, q, q_d, J_m[row + 2, 6 : 6 + m])
    return (
        (0.5 * x[0], 0.5 * y[0], 0.5 * z[0]),
        (x[1], y[1], z[1]),
        (x[2], y[2], z[2]),
    )


def second_order_first_moment(model: Model, i: int, q: Array) -> Array:
    """Return the second-order terms of sum m b of stiffened body i, 1/2 q Z0 q, (k, 3) [kg m].

    q (k, m) are its modal coordinates.
    """
    return 0.5 * np.einsum("aij,ki,kj->ka", _distances(model, i)[:3], q, q, optimize=True)


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
    Z = _distances(model, i)
    G3 = model.G3[three : three + m**3].reshape(m, m, m)
    # acceleration of a station due to its position: w_d x x + w x (w x x)
    turning = np.zeros((len(w), 3, 3))
    turning[:, [2, 0, 1], [1, 2, 0]] = w_d
    turning[:, [1, 2, 0], [2, 0, 1]] = -w_d
    turning += w[:, :, None] * w[:, None, :]
    turning -= np.einsum("ka,ka->k", w, w)[:, None, None] * np.eye(3)
    turned = turning.transpose(0, 2, 1).reshape(-1, 9)
    return np.asarray(
        np.tensordot(a_B, Z[:3], 1) + np.tensordot(turned, Z[3:], 1) + np.tensordot(q_dd, G3, 1)
    )
