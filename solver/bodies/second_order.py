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
from ..rotations import dot
from ..small import mv, tv
from .contractions import add_elastic, contract


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
    work: Array,
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
    work : (12 m + 36,) overwritten
    """
    m = q.shape[0]
    Zq = work[: 12 * m].reshape(12, m)
    parts = work[12 * m : 12 * m + 36].reshape(3, 12)
    contract(Z, q, q_d, Zq, parts)
    by_q, mixed, by_q_d = parts[0], parts[1], parts[2]

    # first moment of mass x, y, z; its bias acceleration; weight per mass in body axes
    x, y, z = 0.5 * by_q[0], 0.5 * by_q[1], 0.5 * by_q[2]
    ww = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    along = w[0] * x + w[1] * y + w[2] * z
    bias_x = w[0] * along - ww * x + 2.0 * (w[1] * mixed[2] - w[2] * mixed[1]) + by_q_d[0]
    bias_y = w[1] * along - ww * y + 2.0 * (w[2] * mixed[0] - w[0] * mixed[2]) + by_q_d[1]
    bias_z = w[2] * along - ww * z + 2.0 * (w[0] * mixed[1] - w[1] * mixed[0]) + by_q_d[2]
    g_x = A_GB[0, 0] * gravity_G[0] + A_GB[1, 0] * gravity_G[1] + A_GB[2, 0] * gravity_G[2]
    g_y = A_GB[0, 1] * gravity_G[0] + A_GB[1, 1] * gravity_G[1] + A_GB[2, 1] * gravity_G[2]
    g_z = A_GB[0, 2] * gravity_G[0] + A_GB[1, 2] * gravity_G[1] + A_GB[2, 2] * gravity_G[2]
    f[3] += y * g_z - z * g_y
    f[4] += z * g_x - x * g_z
    f[5] += x * g_y - y * g_x
    trace = by_q[3] + by_q[7] + by_q[11]  # of sum m b b
    trace_P = mixed[3] + mixed[7] + mixed[11]
    for a in range(3):
        f[a] -= A_GB[a, 0] * bias_x + A_GB[a, 1] * bias_y + A_GB[a, 2] * bias_z
        arm_x = A_GB[a, 2] * y - A_GB[a, 1] * z  # row of - A first~
        arm_y = A_GB[a, 0] * z - A_GB[a, 2] * x
        arm_z = A_GB[a, 1] * x - A_GB[a, 0] * y
        M[a, 3] += arm_x
        M[a, 4] += arm_y
        M[a, 5] += arm_z
        M[3, a] += arm_x
        M[4, a] += arm_y
        M[5, a] += arm_z
        b, c = (a + 1) % 3, (a + 2) % 3
        spin = 0.0  # (J w)_a, to be crossed with w
        coriolis = -trace_P * w[a]
        for d in range(3):
            J_ad = -0.5 * (by_q[3 + 3 * a + d] + by_q[3 + 3 * d + a])
            if a == d:
                J_ad += trace
            M[3 + a, 3 + d] += J_ad
            spin += J_ad * w[d]
            coriolis += mixed[3 + 3 * d + a] * w[d]
        f[3 + b] -= w[c] * spin
        f[3 + c] += w[b] * spin
        f[3 + a] += 2.0 * coriolis - by_q_d[3 + 3 * b + c] + by_q_d[3 + 3 * c + b]
        for k in range(m):
            force = A_GB[a, 0] * Zq[0, k] + A_GB[a, 1] * Zq[1, k] + A_GB[a, 2] * Zq[2, k]
            M[a, 6 + k] += force
            M[6 + k, a] += force
            moment = Zq[3 + 3 * b + c, k] - Zq[3 + 3 * c + b, k]
            M[3 + a, 6 + k] += moment
            M[6 + k, 3 + a] += moment
    for k in range(m):
        f_k = Zq[0, k] * g_x + Zq[1, k] * g_y + Zq[2, k] * g_z
        for a in range(3):
            f_k += ww * Zq[3 + 4 * a, k]
            for b in range(3):
                f_k -= w[a] * w[b] * Zq[3 + 3 * a + b, k]
        f[6 + k] += f_k
    add_elastic(M, f, q, q_d, G3, G4)


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
