"""Accelerations of a mechanism, the derivative of its state, and residuals of its equations."""

import numpy as np

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ..elements.block_vectors import flatten
from ..linear_algebra.mass_solution import factorise_mass, solve_mass
from ..model.coordinates import rates_into
from ..model.model import Model, state_size
from ..model.workspace import GAMMA, PHI, PHI_T, Work, spare_work
from .dense_equations import accelerations, dense
from .evaluation import (
    MOST_PASSES,
    auxiliary_rates_into,
    evaluate,
    evaluate_rates,
    move_forces,
    reads_reactions,
)


def residuals(model: Model, t: Array, y: Array, accelerations: Array, multipliers: Array) -> Array:
    """Return f - M a - Phi_q' lambda, (k, n_vel).

    At times t (k,) and states y (k, n), with accelerations (k, n_vel) and multipliers (k, n_c).
    """
    found = np.zeros((len(t), model.n_vel))
    t, y, a, s = (
        np.ascontiguousarray(part, dtype=float) for part in (t, y, accelerations, multipliers)
    )
    _residuals(model, spare_work(model), t, y, a, s, found)
    return found


@lean
def _residuals(
    model: Model, work: Work, t: Array, y: Array, a: Array, multipliers: Array, found: Array
) -> None:
    plan = model.plan
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        for i in range(model.n_body):
            j, n = model.vel_start[i], plan.size[i]
            for c in range(n):
                left = work.f[i, c]
                for d in range(n):
                    m = work.M[i, c, d] if d <= c else work.M[i, d, c]
                    left -= m * a[k, j + d]
                found[k, j + c] = left
        for joint in range(model.joint_kind.shape[0]):
            begin = model.joint_row[joint]
            for side in range(2):
                body = model.marker_body[model.joint_marker[joint, side]]
                if body >= 0:
                    j, first = model.vel_start[body], plan.side_row[joint, side]
                    for p in range(model.joint_row[joint + 1] - begin):
                        for c in range(plan.size[body]):
                            push = work.J[body, c, first + p] * multipliers[k, begin + p]
                            found[k, j + c] -= push


def by_blocks(model: Model) -> bool:
    """Tell whether the bodies can be eliminated one by one, under the model's treatment.

    Not so where constraints follow from others and the treatment has no penalty.
    """
    return bool(model.redundant == 0 or model.penalty > 0.0)


@inlined
def accelerate(model: Model, work: Work, t: float, y: Array) -> None:
    """Fill work.acceleration and multipliers after an evaluation at t in state y. Paper: Eq. (13).

    For models that are solved `by_blocks`. Forces that read reactions agree with the multipliers;
    where none do, accelerations are not-a-number.
    """
    for k in range(model.n_constraint):
        work.gamma[k] = work.rows[k, GAMMA]
    if model.alpha != 0.0 or model.beta != 0.0:
        evaluate_rates(model, work, y)
        for k in range(model.n_constraint):
            feedback = 2.0 * model.alpha * work.left[k] + model.beta**2 * work.rows[k, PHI]
            work.gamma[k] -= feedback
    factorise_mass(model, work)
    _solve_forces(model, work)
    if reads_reactions(model):
        passed = 0
        while move_forces(model, work, t, passed):
            _solve_forces(model, work)
            passed += 1
            if passed == MOST_PASSES:
                work.acceleration[:] = np.nan
                break


@lean
def _solve_forces(model: Model, work: Work) -> None:
    for i in range(model.n_body):
        for k in range(model.plan.size[i]):
            work.load[i, k] = work.f[i, k]
    solve_mass(model, work)


@lean
def derivative_into(model: Model, work: Work, t: float, y: Array, out: Array) -> None:
    """Fill out (n,) with dy/dt: the index-1 system. Paper: Eq. (14).

    The last entry is the power of drives and dampers, so that the energy
    balance is integrated as accurately as the motion.
    """
    if reads_reactions(model):  # the result is that of the state alone, not of the last evaluation
        work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    accelerate(model, work, t, y)
    rates_into(model, y, out)
    power = work.power[0]
    for k in range(model.n_constraint):
        power += work.multipliers[k] * work.rows[k, PHI_T]
    auxiliary_rates_into(model, work, t, out)
    out[model.n_pos + model.n_vel + model.n_aux] = power
    flatten(model, work.acceleration, out, model.n_pos)


def dense_derivative_into(model: Model, work: Work, t: float, y: Array, out: Array) -> Array:
    """As `derivative_into` for any model, by dense linear algebra; return the multipliers."""
    work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    equations = dense(model, work)
    acceleration, multipliers = accelerations(model, equations, y)
    if reads_reactions(model):
        passed, work.multipliers[:] = 0, multipliers
        while move_forces(model, work, t, passed):
            equations = dense(model, work)
            acceleration, multipliers = accelerations(model, equations, y)
            passed, work.multipliers[:] = passed + 1, multipliers
            if passed == MOST_PASSES:
                acceleration = np.full(model.n_vel, np.nan)
                break
    rates_into(model, y, out)
    out[model.n_pos : model.n_pos + model.n_vel] = acceleration
    if model.n_aux > 0:
        auxiliary_rates_into(model, work, t, out)
    out[-1] = multipliers @ equations.Phi_t + equations.power[0]
    return multipliers


def derivative(model: Model, t: float, y: Array) -> Array:
    """Return dy/dt, (n,), in a new array; see `derivative_into`."""
    out = np.empty(state_size(model))
    fill = derivative_into if by_blocks(model) else dense_derivative_into
    fill(model, spare_work(model), t, y, out)
    return out
