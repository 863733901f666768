"""Geometric stiffening: what second-order displacements add to a floating body.

A mass station stands at b = x + phi q + 1/2 q' h q. The kinetic energy is that of the linear body
(floating_frame.py) with these changes, and all equations follow from it, so that energy and both
momenta are kept whatever the motion is:

    sum m b                    S0 + S q + 1/2 q Z0 q
    its slope by q             C = S + Z0 q
    sum m b_a b_b              + 1/2 q (Z1_ab + Z1_ba) q
    D_ab = sum m b_a db_b/dq   + Z1_ab q
    M_qq                       + E q + (E q)' less what is counted twice, E = G3 + G4 q

Terms of third and higher order in q are left out of the first four; M_qq is complete, a sum of
squares over the stations, which keeps the mass matrix positive definite (docs/stiffening.md).
"""

from ..compiled import jit
from ..model import Model
from ..package.schema import Array
from ..rotations import cross, dot, skew
from ..small import add, add_transposed, mm, mv, tv


@jit
def add_second_order(
    M: Array,
    f: Array,
    A_GB: Array,
    w: Array,
    q: Array,
    q_d: Array,
    gravity_G: Array,
    Z: Array,
    G3: Array,
    G4: Array,
) -> None:
    """Add to M and f of one body what its second-order displacements change.

    Parameters
    ----------
    M : (6 + m, 6 + m), f : (6 + m,)
        The body's blocks, added to in place after `add_inertia`.
    A_GB : (3, 3); w : (3,) body components [rad/s]; q, q_d : (m,)
    gravity_G : (3,) [m/s2]
    Z : (12 m, m) rows Z0 (3, m), then Z1 (3, 3, m); G3 : (m, m m); G4 : (m m m, m), rows i, j, l
        of G4_ij,kl and columns k
        Second-order invariants (package/schema.py).
    """
    m = q.shape[0]
    Zq = mv(Z, q).reshape(12, m)
    Zq_d = mv(Z, q_d).reshape(12, m)
    by_q = mv(Zq, q)  # q Z q
    by_mixed = mv(Zq, q_d)  # q Z q_d
    by_q_d = mv(Zq_d, q_d)  # q_d Z q_d
    E = G3 + mv(G4, q).reshape(m, m * m)  # E_i,jl = sum m (db/dq_i) . h_jl
    E_rows = E.reshape(m * m, m)
    along_q = mv(E_rows, q)
    along_q_d = mv(E_rows, q_d)
    G3_q = mv(G3.reshape(m * m, m), q)

    first = 0.5 * by_q[0:3]
    bias = mv(A_GB, cross(w, cross(w, first)) + 2.0 * cross(w, by_mixed[0:3]) + by_q_d[0:3])
    g_B = tv(A_GB, gravity_G)
    weight = cross(first, g_B)
    C_G = mm(A_GB, Zq[0:3])
    arm_G = mm(A_GB, skew(first))
    add(M, 0, 3, arm_G, -1.0)
    add_transposed(M, 3, 0, arm_G, -1.0)
    trace = by_q[3] + by_q[7] + by_q[11]  # of sum m b b
    trace_P = by_mixed[3] + by_mixed[7] + by_mixed[11]
    ww = dot(w, w)
    for a in range(3):
        f[a] -= bias[a]
        b, c = (a + 1) % 3, (a + 2) % 3
        for d in range(3):
            J_ad = -0.5 * (by_q[3 + 3 * a + d] + by_q[3 + 3 * d + a])
            if a == d:
                J_ad += trace
            M[3 + a, 3 + d] += J_ad
            f[3 + b] -= w[c] * J_ad * w[d]
            f[3 + c] += w[b] * J_ad * w[d]
            f[3 + a] += 2.0 * by_mixed[3 + 3 * d + a] * w[d]
        f[3 + a] += weight[a] - 2.0 * trace_P * w[a]
        f[3 + a] -= by_q_d[3 + 3 * b + c] - by_q_d[3 + 3 * c + b]
        for k in range(m):
            M[a, 6 + k] += C_G[a, k]
            M[6 + k, a] += C_G[a, k]
            moment = Zq[3 + 3 * b + c, k] - Zq[3 + 3 * c + b, k]
            M[3 + a, 6 + k] += moment
            M[6 + k, 3 + a] += moment
    for i in range(m):
        f_i = Zq[0, i] * g_B[0] + Zq[1, i] * g_B[1] + Zq[2, i] * g_B[2]
        for a in range(3):
            f_i += ww * Zq[3 + 4 * a, i]
            for b in range(3):
                f_i -= w[a] * w[b] * Zq[3 + 3 * a + b, i]
        for j in range(m):
            f_i -= along_q_d[i * m + j] * q_d[j]
            M[6 + i, 6 + j] += along_q[i * m + j] + G3_q[j * m + i]
        f[6 + i] += f_i


@jit
def second_order_of(model: Model, i: int) -> tuple[Array, Array, Array]:
    """Return Z (12 m, m), G3 (m, m m) and G4 (m m m, m) of stiffened body i."""
    m = model.n_mode[i]
    two, three, four = model.second_start[i], model.third_start[i], model.fourth_start[i]
    return (
        model.Z[12 * two : 12 * (two + m * m)].reshape(12 * m, m),
        model.G3[three : three + m * m * m].reshape(m, m * m),
        model.G4[four : four + m * m * m * m].reshape(m * m * m, m),
    )


@jit
def second_order_first_moment(Z: Array, q: Array) -> Array:
    """Return what the bent body adds to sum m b, 1/2 q Z0 q, (3,) [kg m]; Z as above."""
    m = q.shape[0]
    return 0.5 * mv(mv(Z[0 : 3 * m], q).reshape(3, m), q)


@jit
def stiffening_matrix(w: Array, w_d: Array, a_B: Array, q_dd: Array, Z: Array, G3: Array) -> Array:
    """Return the geometric stiffness of a body's own inertia loads, (m, m) [N m].

    What the elastic forces gain with q while all accelerations are held: positive where the
    motion pulls at the body, negative where it presses.

    Parameters
    ----------
    w, w_d : (3,) spin and its rate, body components
    a_B : (3,) acceleration of the frame origin less gravity, body components [m/s2]
    q_dd : (m,) modal accelerations
    Z, G3 : as in `add_second_order`
    """
    m = q_dd.shape[0]
    Z4 = Z.reshape(12, m, m)
    ww = dot(w, w)
    out = tv(G3, q_dd).reshape(m, m)
    for i in range(m):
        for j in range(m):
            s = 0.0
            for a in range(3):
                b, c = (a + 1) % 3, (a + 2) % 3
                s += a_B[a] * Z4[a, i, j] - ww * Z4[3 + 4 * a, i, j]
                s += w_d[a] * (Z4[3 + 3 * b + c, i, j] - Z4[3 + 3 * c + b, i, j])
                for d in range(3):
                    s += w[a] * w[d] * Z4[3 + 3 * a + d, i, j]
            out[i, j] += s
    return out


@jit
def bend_marker(
    H: Array,
    q: Array,
    q_d: Array,
    phi: Array,
    psi: Array,
    b: Array,
    b_d: Array,
    b_dd: Array,
    theta: Array,
    theta_d: Array,
    theta_dd: Array,
) -> tuple[Array, Array]:
    """Take a marker's motion in its body from first to second order.

    Position b, rotation vector theta, their rates and their accelerations at q_dd = 0 (all (3,))
    are added to in place. Returns the slopes phi + H q and psi + H_psi q, (3, m) each.

    Parameters
    ----------
    H : (6 m, m) rows H (3, m), H_psi (3, m)
    phi, psi : (3, m) shapes of the marker
    """
    m = q.shape[0]
    Hq = mv(H, q).reshape(6, m)
    by_q, by_mixed = mv(Hq, q), mv(Hq, q_d)
    by_q_d = mv(mv(H, q_d).reshape(6, m), q_d)
    for a in range(3):
        b[a] += 0.5 * by_q[a]
        b_d[a] += by_mixed[a]
        b_dd[a] += by_q_d[a]
        theta[a] += 0.5 * by_q[3 + a]
        theta_d[a] += by_mixed[3 + a]
        theta_dd[a] += by_q_d[3 + a]
    return phi + Hq[0:3], psi + Hq[3:6]
