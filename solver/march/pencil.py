"""Newton's matrix of an implicit step, s I - df/dy, with the structure of a mechanism.

Of df/dy only what can be stiff is kept: modal stiffness K and damping D, through the response to
forces R = [M Phi_q'; Phi_q 0]^-1. A change y = (G x + rest, v) of positions and velocities with
right-hand side (r_q, r_v) then follows from one system of the same structure as the mass matrix:

    rho = G^+ r_q,   (s^2 M + s D + K) x + Phi_q' mu = M (r_v + s rho) + D rho,
    Phi_q x = Phi_q (r_v + s rho) / s^2,
    delta v = s x - rho,   delta q = G x + (r_q - G rho) / s,

where qdot = G v. The same code serves real and complex s.
"""

from typing import NamedTuple

import numpy as np

from ..compiled import inlined, jit
from ..elimination import factorise, solve
from ..model import Model
from ..package.schema import Array
from ..workspace import Factors, Work, new_factors


class Pencil(NamedTuple):
    """Factors for one s, and the memory of a solution."""

    factors: Factors
    load: Array  # (nb, n)
    rho: Array  # (nb, n)
    x: Array  # (nb, n)
    gamma: Array  # (n_c,)
    mu: Array  # (n_c,)


class Frozen(NamedTuple):
    """Mass matrix, Jacobian and Euler parameters at the beginning of a step."""

    M: Array  # (nb, n, n) lower triangles
    J: Array  # (nb, n, r)
    softness: Array  # (n_c,)
    p: Array  # (nb, 4)


@jit
def new_pencil(model: Model, one: float) -> Pencil:
    """Return memory of the type of `one`."""
    nb, n, n_c = model.n_body, model.plan.widest, model.n_constraint
    return Pencil(
        new_factors(model, one),
        np.zeros((nb, n)) * one,
        np.zeros((nb, n)) * one,
        np.zeros((nb, n)) * one,
        np.zeros(n_c) * one,
        np.zeros(n_c) * one,
    )


@jit
def new_frozen(model: Model) -> Frozen:
    """Return memory."""
    nb, n, r = model.n_body, model.plan.widest, model.plan.most_rows
    n_c = model.n_constraint
    return Frozen(np.zeros((nb, n, n)), np.zeros((nb, n, r)), np.zeros(n_c), np.zeros((nb, 4)))


@jit
def freeze(model: Model, work: Work, y: Array, frozen: Frozen) -> None:
    """Keep what the last evaluation, in state y, has filled and `prepare` found."""
    frozen.M[:] = work.M
    frozen.J[:] = work.J
    frozen.softness[:] = work.softness
    for i in range(model.n_body):
        for k in range(4):
            frozen.p[i, k] = y[model.pos_start[i] + 3 + k]


@jit
def factorise_pencil(model: Model, frozen: Frozen, pencil: Pencil, s: complex) -> None:
    """Factorise for s [1/s]."""
    L = pencil.factors.L
    for i in range(model.n_body):
        n, m, two = model.plan.size[i], model.n_mode[i], model.square_start[i]
        for a in range(n):
            for b in range(a + 1):
                L[i, a, b] = s * s * frozen.M[i, a, b]
        for a in range(m):
            for b in range(a + 1):
                k = two + a * m + b
                L[i, 6 + a, 6 + b] += model.K_qq[k] + s * model.D_qq[k]
    # the rows' mass is s^2 times that of the mass matrix
    pencil.gamma[:] = frozen.softness / (s * s)
    factorise(model.plan, pencil.factors, frozen.J, pencil.gamma)


@jit
def solve_pencil(
    model: Model, frozen: Frozen, pencil: Pencil, s: complex, r: Array, delta: Array
) -> None:
    """Fill delta (n,) with the answer to r (n,), both in the coordinates of y."""
    load, rho, x, gamma = pencil.load, pencil.rho, pencil.x, pencil.gamma
    n_pos = model.n_pos
    plan = model.plan
    for i in range(model.n_body):
        n, m, two = plan.size[i], model.n_mode[i], model.square_start[i]
        a, j = model.pos_start[i], n_pos + model.vel_start[i]
        _spin_of(frozen.p[i], r, a + 3, rho[i])
        for k in range(3):
            rho[i, k] = r[a + k]
        for k in range(m):
            rho[i, 6 + k] = r[a + 7 + k]
        for k in range(n):
            x[i, k] = r[j + k] + s * rho[i, k]
            load[i, k] = 0.0
        for k in range(n):
            for b in range(k):
                c = frozen.M[i, k, b]
                load[i, k] += c * x[i, b]
                load[i, b] += c * x[i, k]
            load[i, k] += frozen.M[i, k, k] * x[i, k]
        for k in range(m):
            for b in range(m):
                load[i, 6 + k] += model.D_qq[two + k * m + b] * rho[i, 6 + b]
    gamma[:] = 0.0
    for k in range(model.joint_kind.shape[0]):
        begin = model.joint_row[k]
        for side in range(2):
            body = model.marker_body[model.joint_marker[k, side]]
            if body >= 0:
                first = plan.side_row[k, side]
                for p in range(model.joint_row[k + 1] - begin):
                    for b in range(plan.size[body]):
                        gamma[begin + p] += frozen.J[body, b, first + p] * x[body, b] / (s * s)
    solve(plan, pencil.factors, load, gamma, x, pencil.mu)
    for i in range(model.n_body):
        m = model.n_mode[i]
        a, j = model.pos_start[i], n_pos + model.vel_start[i]
        for k in range(plan.size[i]):
            delta[j + k] = s * x[i, k] - rho[i, k]
        for k in range(3):
            delta[a + k] = x[i, k]
        for k in range(m):
            delta[a + 7 + k] = x[i, 6 + k]
        for k in range(3):
            x[i, 3 + k] -= rho[i, 3 + k] / s
        _parameters_of(frozen.p[i], x[i], delta, a + 3)
        for k in range(4):
            delta[a + 3 + k] += r[a + 3 + k] / s
    delta[n_pos + model.n_vel] = r[n_pos + model.n_vel] / s


@inlined
def _spin_of(p: Array, r: Array, a: int, rho: Array) -> None:
    """rho[3:6] = 2 E' r[a:a+4] / p'p: the rotation that changes Euler parameters so."""
    e0, e1, e2, e3 = p[0], p[1], p[2], p[3]
    c = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    r0, r1, r2, r3 = r[a], r[a + 1], r[a + 2], r[a + 3]
    rho[3] = c * (-e1 * r0 + e0 * r1 + e3 * r2 - e2 * r3)
    rho[4] = c * (-e2 * r0 - e3 * r1 + e0 * r2 + e1 * r3)
    rho[5] = c * (-e3 * r0 + e2 * r1 - e1 * r2 + e0 * r3)


@inlined
def _parameters_of(p: Array, x: Array, delta: Array, a: int) -> None:
    """delta[a:a+4] = E x[3:6] / 2: the change of Euler parameters by a small rotation."""
    e0, e1, e2, e3 = 0.5 * p[0], 0.5 * p[1], 0.5 * p[2], 0.5 * p[3]
    delta[a] = -e1 * x[3] - e2 * x[4] - e3 * x[5]
    delta[a + 1] = e0 * x[3] - e3 * x[4] + e2 * x[5]
    delta[a + 2] = e3 * x[3] + e0 * x[4] - e1 * x[5]
    delta[a + 3] = -e2 * x[3] + e1 * x[4] + e0 * x[5]
