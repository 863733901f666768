"""The equations of motion as dense arrays, and their solution by dense linear algebra."""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array
from ...math.compiled import lean
from ..elements.constraints.augmented_lagrangian import augmented_lagrangian
from ..elements.constraints.baumgarte import stabilised
from ..elements.constraints.minimum_norm import minimum_norm
from ..elements.constraints.saddle_point import saddle_point
from ..model.model import Model
from ..model.workspace import GAMMA, PHI, PHI_T, Work, spare_work
from .energy import stored_energies
from .evaluation import evaluate


class Equations(NamedTuple):
    """One evaluation of the equations of motion at (t, y), as dense arrays."""

    M: Array  # (n_vel, n_vel) mass matrix
    f: Array  # (n_vel,) loads, quadratic velocity terms, elastic and damping forces
    Phi_q: Array  # (n_c, n_vel) d Phidot / d velocities
    C: Array  # (n_c, 12) the same by the velocities of each joint's two markers (joints/rows.py)
    Phi: Array  # (n_c,)
    Phi_t: Array  # (n_c,)
    gamma: Array  # (n_c,) gamma* of Eq. (11)
    power: Array  # (1,) of dampers, actuators and loads [W]
    potential: Array  # (1,) energy stored in force elements [J]


def assemble(model: Model, t: float, y: Array) -> Equations:
    """Return the equations at time t and state y as new dense arrays; no reactions are read."""
    work = spare_work(model)
    work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    return dense(model, work)


def dense(model: Model, work: Work) -> Equations:
    """Return the last evaluation as dense arrays."""
    n_vel, n_c = model.n_vel, model.n_constraint
    M, f, Phi_q = np.zeros((n_vel, n_vel)), np.empty(n_vel), np.zeros((n_c, n_vel))
    _dense_into(model, work, M, f, Phi_q)
    rows = work.rows
    return Equations(
        M,
        f,
        Phi_q,
        rows[:, :PHI].copy(),
        rows[:, PHI].copy(),
        rows[:, PHI_T].copy(),
        rows[:, GAMMA].copy(),
        work.power[:1].copy(),
        work.power[1:].copy(),
    )


@lean
def _dense_into(model: Model, work: Work, M: Array, f: Array, Phi_q: Array) -> None:
    """Fill the mass matrix, the loads and the Jacobian, which is zero before."""
    plan = model.plan
    for i in range(model.n_body):
        j, begin = model.vel_start[i], plan.row_start[i]
        for a in range(plan.size[i]):
            f[j + a] = work.f[i, a]
            for b in range(a + 1):
                M[j + a, j + b] = M[j + b, j + a] = work.M[i, a, b]
        for p in range(begin, plan.row_start[i + 1]):
            for a in range(plan.size[i]):
                Phi_q[plan.body_row[p], j + a] += work.J[i, a, p - begin]


def masses_and_jacobians(model: Model, t: Array, y: Array) -> tuple[Array, Array]:
    """Return mass matrices (k, n_vel, n_vel) and Jacobians (k, n_c, n_vel) of states y (k, n)."""
    k, n = len(t), model.n_vel
    M, Phi_q = np.zeros((k, n, n)), np.zeros((k, model.n_constraint, n))
    work = spare_work(model)
    work.multipliers[:] = 0.0
    t, y = np.ascontiguousarray(t, dtype=float), np.ascontiguousarray(y, dtype=float)
    _all_dense(model, work, t, y, M, np.empty(n), Phi_q)
    return M, Phi_q


@lean
def _all_dense(
    model: Model, work: Work, t: Array, y: Array, M: Array, f: Array, Phi_q: Array
) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        _dense_into(model, work, M[k], f, Phi_q[k])


def constraint_rates(model: Model, equations: Equations, y: Array) -> Array:
    """Return Phidot (n_c,) in state y; `equations` are those of the same state."""
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    return equations.Phi_q @ velocities + equations.Phi_t


def solve_dense(model: Model, equations: Equations, f: Array, gamma: Array) -> tuple[Array, Array]:
    """Solve for accelerations and multipliers with right-hand sides f (n_vel,) and gamma (n_c,).

    M a + Phi_q' lambda = f and Phi_q a = gamma, by the model's treatment, with dense
    linear algebra. The same equations hold for impulses and small motions.
    """
    if model.penalty > 0.0 and model.n_constraint > 0:
        return augmented_lagrangian(
            equations.M,
            f,
            equations.Phi_q,
            gamma,
            model.inertia_scale,
            model.penalty,
            model.multiplier_tolerance,
            model.multiplier_iterations,
        )
    if model.redundant > 0:
        return minimum_norm(
            equations.M, f, equations.Phi_q, gamma, model.inertia_scale, model.redundant
        )
    return saddle_point(equations.M, f, equations.Phi_q, gamma)


def accelerations(model: Model, equations: Equations, y: Array) -> tuple[Array, Array]:
    """Return accelerations (n_vel,) and multipliers (n_c,) in state y. Paper: Eq. (13), Eq. (14).

    The force of constraint i is -Phi_q[i] lambda_i. Multipliers of redundant
    constraints are those of least norm.
    """
    Phi_d = constraint_rates(model, equations, y)
    gamma = stabilised(equations.gamma, equations.Phi, Phi_d, model.alpha, model.beta)
    return solve_dense(model, equations, equations.f, gamma)


def energies(model: Model, equations: Equations, y: Array) -> Array:
    """Return kinetic, strain and potential energy, (3,) [J]. Paper: Eq. (1), Eq. (3).

    `equations` are those of state y.

    Potential energy is that of weight (zero for a mass point at the global origin) and of springs.
    """
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    out = np.zeros(3)
    out[0] = 0.5 * velocities @ (equations.M @ velocities)
    stored_energies(model, y, np.empty((3, 3)), out)
    out[2] += equations.potential[0]
    return out
