"""Newton's matrix of an implicit step, with the structure of a mechanism.

Of the derivatives of the equations only what can be stiff is kept: modal stiffness K and damping
D. With a rate of s per change (s = gamma / h, real or complex), a change x of positions along
the velocity coordinates, delta v of velocities and mu of multipliers answers residuals

    R = f - M vdot - Phi_q' lambda,   c = gamma - Phi_q vdot,   rho = G^+ (G v - qdot)

by one system of the same structure as that of the mass matrix:

    (s^2 M + s D + K) x + Phi_q' mu = R + s M rho + D rho,
    Phi_q x = (c + (s + 2 alpha) Phi_q rho) / (s^2 + 2 alpha s + beta^2),
    delta v = s x - rho,   delta q = G x + (r_q - G rho) / s,

with the feedback alpha, beta of Baumgarte's treatment in c: without it in the matrix, Newton's
iteration would converge only where steps are much shorter than 1 / alpha and 1 / beta.
"""

from typing import Any, NamedTuple

import numpy as np

from ...dynamics.elimination import factorise, solve
from ...dynamics.model import Model
from ...dynamics.system import REGULAR, soften
from ...dynamics.workspace import Factors, Work, new_factors
from ...math.arrays import Array
from ...math.compiled import inlined, lean, structure
from ...math.rotations import along_parameters


@structure
class Pencil(NamedTuple):
    """Factors for one s, and a right-hand side with its answer."""

    factors: Factors
    load: Array  # (nb, n) R
    gamma: Array  # (n_c,) c
    r: Array  # (n,) r_q
    rho: Array  # (nb, n)
    x: Array  # (nb, n)
    delta: Array  # (n,) answer in the coordinates of y
    mu: Array  # (n_c,)


@structure
class Frozen(NamedTuple):
    """Mass matrix, Jacobian and Euler parameters at one place of a step."""

    M: Array  # (nb, n, n) lower triangles
    J: Array  # (nb, n, r)
    softness: Array  # (n_c,)
    p: Array  # (nb, 4)


def new_pencil(model: Model, one: Any) -> Pencil:
    """Return memory of the type of `one`."""
    nb, n, n_c = model.n_body, model.plan.widest, model.n_constraint
    n_y = model.n_pos + model.n_vel + 1
    return Pencil(
        new_factors(model, one),
        np.zeros((nb, n)) * one,
        np.zeros(n_c) * one,
        np.zeros(n_y) * one,
        np.zeros((nb, n)) * one,
        np.zeros((nb, n)) * one,
        np.zeros(n_y) * one,
        np.zeros(n_c) * one,
    )


def new_frozen(model: Model) -> Frozen:
    """Return memory."""
    nb, n, r = model.n_body, model.plan.widest, model.plan.most_rows
    n_c = model.n_constraint
    return Frozen(np.zeros((nb, n, n)), np.zeros((nb, n, r)), np.zeros(n_c), np.zeros((nb, 4)))


@inlined
def freeze(model: Model, work: Work, y: Array, frozen: Frozen) -> None:
    """Keep what the last evaluation, in state y, has filled."""
    plan, row_start = model.plan, model.plan.row_start
    frozen.softness[:] = 0.0
    for i in range(plan.size.shape[0]):
        n, r = plan.size[i], row_start[i + 1] - row_start[i]
        M, J, M_0, J_0 = work.M[i], work.J[i], frozen.M[i], frozen.J[i]
        for a in range(n):
            M_0[a, a] = M[a, a]
            for b in range(min(a, plan.lead[i])):
                M_0[a, b] = M[a, b]
            for p in range(r):
                J_0[a, p] = J[a, p]
        for k in range(4):
            frozen.p[i, k] = y[model.pos_start[i] + 3 + k]


@lean
def factorise_pencil(
    model: Model, frozen: Frozen, pencil: Pencil, mass: complex, damping: complex, stiffness: float
) -> None:
    """Factorise mass M + damping D + stiffness K with the constraints.

    Rows that depend on each other are softened as in `prepare` (system.py).
    """
    _factorise(model, frozen, pencil, mass, damping, stiffness)
    if model.penalty > 0.0 and pencil.factors.regular[0] < REGULAR:
        soften(model, frozen.J, frozen.softness)
        _factorise(model, frozen, pencil, mass, damping, stiffness)


@inlined
def _factorise(
    model: Model, frozen: Frozen, pencil: Pencil, mass: complex, damping: complex, stiffness: float
) -> None:
    plan = model.plan
    for i in range(plan.size.shape[0]):
        n, m, two = plan.size[i], model.n_mode[i], model.square_start[i]
        L, M = pencil.factors.L[i], frozen.M[i]
        for a in range(n):
            L[a, a] = mass * M[a, a]
            for b in range(min(a, plan.lead[i])):
                L[a, b] = mass * M[a, b]
        for a in range(m):
            for b in range(0 if plan.lead[i] > 6 else a, a + 1):
                k = two + a * m + b
                L[6 + a, 6 + b] += stiffness * model.K_qq[k] + damping * model.D_qq[k]
    for k in range(frozen.softness.shape[0]):
        pencil.mu[k] = frozen.softness[k] / mass
    factorise(plan, pencil.factors, frozen.J, pencil.mu)


@lean
def solve_pencil(model: Model, frozen: Frozen, pencil: Pencil, s: complex) -> None:
    """Fill pencil.delta (n,) and mu (n_c,) with the answer to load, gamma and r."""
    load, rho, x, gamma, r, delta = (
        pencil.load,
        pencil.rho,
        pencil.x,
        pencil.gamma,
        pencil.r,
        pencil.delta,
    )
    n_pos, plan = model.n_pos, model.plan
    row_start, body_row = plan.row_start, plan.body_row
    fed = s + 2.0 * model.alpha
    for i in range(plan.size.shape[0]):
        n, m, two = plan.size[i], model.n_mode[i], model.square_start[i]
        a = model.pos_start[i]
        _spin_of(frozen.p[i], r, a + 3, rho[i])
        for k in range(3):
            rho[i, k] = r[a + k]
        for k in range(m):
            rho[i, 6 + k] = r[a + 7 + k]
        M, J, first = frozen.M[i], frozen.J[i], row_start[i]
        count = row_start[i + 1] - first
        for k in range(n):
            z = s * rho[i, k]
            w = load[i, k] + M[k, k] * z
            for b in range(min(k, plan.lead[i])):
                w += M[k, b] * s * rho[i, b]
                load[i, b] += M[k, b] * z
            load[i, k] = w
            for p in range(count):
                gamma[body_row[first + p]] += J[k, p] * fed * rho[i, k]
        for k in range(m):
            w = load[i, 6 + k]
            for b in range(m):
                w += model.D_qq[two + k * m + b] * rho[i, 6 + b]
            load[i, 6 + k] = w
    c = 1.0 / (s * s + 2.0 * model.alpha * s + model.beta**2)
    for k in range(gamma.shape[0]):
        gamma[k] *= c
    solve(plan, pencil.factors, load, gamma, x, pencil.mu)
    c = 1.0 / s
    for i in range(plan.size.shape[0]):
        m = model.n_mode[i]
        a, j = model.pos_start[i], n_pos + model.vel_start[i]
        for k in range(plan.size[i]):
            delta[j + k] = s * x[i, k] - rho[i, k]
        for k in range(3):
            delta[a + k] = x[i, k]
        for k in range(m):
            delta[a + 7 + k] = x[i, 6 + k]
        for k in range(3):
            x[i, 3 + k] -= rho[i, 3 + k] * c
        # E x / 2: the change of Euler parameters by a small rotation
        turned = along_parameters(frozen.p[i], 0, 0.5 * x[i, 3], 0.5 * x[i, 4], 0.5 * x[i, 5])
        for k in range(4):
            delta[a + 3 + k] = turned[k] + r[a + 3 + k] * c


@inlined
def _spin_of(p: Array, r: Array, a: int, rho: Array) -> None:
    """rho[3:6] = 2 E' r[a:a+4] / p'p: the rotation that changes Euler parameters so."""
    e0, e1, e2, e3 = p[0], p[1], p[2], p[3]
    c = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    r0, r1, r2, r3 = r[a], r[a + 1], r[a + 2], r[a + 3]
    rho[3] = c * (-e1 * r0 + e0 * r1 + e3 * r2 - e2 * r3)
    rho[4] = c * (-e2 * r0 - e3 * r1 + e0 * r2 + e1 * r3)
    rho[5] = c * (-e3 * r0 + e2 * r1 - e1 * r2 + e0 * r3)
