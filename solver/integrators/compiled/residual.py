"""Residuals of the equations of motion, for given rates and multipliers.

Implicit steps need no accelerations: they ask how far M vdot + Phi_q' lambda = f and
Phi_q vdot = gamma are from being met. That spares a factorisation of the mass matrix.
"""

from ...dynamics.evaluation.evaluation import auxiliary_rates_into, evaluate, evaluate_rates
from ...dynamics.model.coordinates import rates_into
from ...dynamics.model.model import Model
from ...dynamics.model.workspace import GAMMA, PHI, PHI_T, Work
from ...math.arrays import Array
from ...math.compiled import inlined, lean
from .newton.elements import element_residual


@lean
def residual(
    model: Model,
    work: Work,
    t: float,
    y: Array,
    rate: Array,
    multipliers: Array,
    load: Array,
    gamma: Array,
    r: Array,
) -> float:
    """Evaluate at (t, y) and fill the residuals of rates and multipliers; return the power [W].

    Parameters
    ----------
    rate : (n,) of y
    multipliers : (n_r,) of constraints, and forces of elements
    load : (nb, n), f - M vdot - Phi_q' lambda
    gamma : (n_r,), gamma - Phi_q vdot, with the feedback of Baumgarte's treatment, and what the
        forces of elements leave of their law
    r : (n,), of which positions: G v - qdot, and auxiliary states: their law less zdot
    """
    for k in range(model.n_constraint):
        work.multipliers[k] = multipliers[k]
    evaluate(model, work, t, y)
    rates_into(model, y, r)
    for i in range(model.n_pos):
        r[i] -= rate[i]
    auxiliary_rates_into(model, work, t, r)
    for i in range(model.n_pos + model.n_vel, model.n_pos + model.n_vel + model.n_aux):
        r[i] -= rate[i]
    for k in range(model.n_constraint):
        gamma[k] = work.rows[k, GAMMA]
    if model.alpha != 0.0 or model.beta != 0.0:
        evaluate_rates(model, work, y)
        for k in range(model.n_constraint):
            feedback = 2.0 * model.alpha * work.left[k] + model.beta**2 * work.rows[k, PHI]
            gamma[k] -= feedback
    inertia_residual(model, work.M, work.J, rate, multipliers, work.f, load, gamma)
    if model.plan.element_row.shape[0] > 0:
        element_residual(model, work, multipliers, load, gamma)
    power = work.power[0]
    for k in range(model.n_constraint):
        power += multipliers[k] * work.rows[k, PHI_T]
    return power


@inlined
def inertia_residual(
    model: Model,
    M: Array,
    J: Array,
    rate: Array,
    multipliers: Array,
    f: Array,
    load: Array,
    gamma: Array,
) -> None:
    """load = f - M vdot - Phi_q' lambda (nb, n); gamma -= Phi_q vdot."""
    plan, row_start, body_row = model.plan, model.plan.row_start, model.plan.body_row
    for i in range(plan.size.shape[0]):
        n, j = plan.size[i], model.n_pos + model.vel_start[i]
        first = row_start[i]
        count = row_start[i + 1] - first
        for k in range(n):
            a = rate[j + k]
            s = f[i, k] - M[i, k, k] * a
            for b in range(min(k, plan.lead[i])):
                s -= M[i, k, b] * rate[j + b]
                load[i, b] -= M[i, k, b] * a
            for p in range(count):
                row = body_row[first + p]
                s -= J[i, k, p] * multipliers[row]
                gamma[row] -= J[i, k, p] * a
            load[i, k] = s
