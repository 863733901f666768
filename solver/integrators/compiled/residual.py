"""Residuals of the equations of motion, for given rates and multipliers.

Implicit steps need no accelerations: they ask how far M vdot + Phi_q' lambda = f and
Phi_q vdot = gamma are from being met. That spares a factorisation of the mass matrix.

A force element pushes with -g'(k e + c edot) (dynamics/elements/forces/contract.py). In Newton's
iteration F stands for k e + c edot, and k e + c edot - F = 0 is an equation of its own. Without it,
a stiff element would answer a small error of e with a large force, in a direction g that is not
exactly that of Newton's matrix: the iteration would diverge from some stiffness on, as the square
of the angle by which g turns in a step. With it, the limit of large k is the constraint e = 0 with
the multiplier F.
"""

from typing import Any

from ...dynamics.elements.forces.table import FIRST_LOAD, element_rows, element_wrench
from ...dynamics.evaluation.evaluation import (
    auxiliary_rates_into,
    evaluate,
    evaluate_rates,
    fill_jacobian,
)
from ...dynamics.model.coordinates import rates_into
from ...dynamics.model.model import (
    GAMMA,
    PHI,
    PHI_T,
    Model,
    Workspace,
)
from ...dynamics.model.motion import DAMPING, FORCE, N_ELEMENT_ROW, STIFFNESS
from ...math.arrays import Array
from ...math.compiled import inlined, lean


@inlined
def element_rows_at(model: Model, work: Workspace, e: int) -> int:
    """Fill work.element_used with the rows of element e at the last evaluation; return how many.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    e : number of the force element
    """
    layout = model.layout
    begin, end = layout.element_start[e], layout.element_start[e + 1]
    if begin < end:
        along, kind = model.quantities.along[e], model.force_kind[e]
        if along >= 0:
            for j in range(12):
                work.element[0, j] = work.g[along, j]
        else:
            one = work.motion[model.force_marker[e, 0]]
            two = work.motion[model.force_marker[e, 1]]
            if kind >= FIRST_LOAD:
                unit = element_wrench(kind, one, two, model.force_parameters[e], 1.0)
                work.element[0, :6] = 0.0
                for j in range(3):
                    work.element[0, 6 + j] = unit.force[j]
                    work.element[0, 9 + j] = unit.moment[j]
            else:
                element_rows(kind, one, two, model.force_parameters[e], work.element)
        if along >= 0 or kind >= FIRST_LOAD:  # -g'F with F = -size
            work.element[0, FORCE] = -work.size[e, 0]
            work.element[0, STIFFNESS] = max(0.0, -work.size[e, 1])
            work.element[0, DAMPING] = max(0.0, -work.size[e, 2])
        for k in range(begin, end):
            for j in range(N_ELEMENT_ROW):
                work.element_used[k - begin, j] = work.element[layout.element_row[k], j]
    return int(end - begin)


@lean
def freeze_elements(
    model: Model, work: Workspace, stiffness: Array, damping: Array, J: Array
) -> None:
    """Fill stiffness and damping (n_e,) and the columns of elements in J (nb, n, r).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    stiffness : stiffness of the element rows (n_e,), to fill
    damping : damping of the element rows (n_e,), to fill
    J : Jacobians by bodies (nb, n, r), columns of elements included
    """
    layout = model.layout
    for e in range(model.force_kind.shape[0]):
        count, begin = element_rows_at(model, work, e), layout.element_start[e]
        for k in range(count):
            stiffness[begin + k] = work.element_used[k, STIFFNESS]
            damping[begin + k] = work.element_used[k, DAMPING]
        for side in range(2):
            first, marker = layout.element_side[e, side], model.force_marker[e, side]
            if first >= 0:
                body, rows = model.marker_body[marker], work.element_used[:count]
                J_m, n = work.J_m[marker], layout.size[body]
                fill_jacobian(J[body], first, rows, 6 * side, J_m, n)


@lean
def element_residual(
    model: Model, work: Workspace, forces: Array, load: Array, gamma: Array
) -> None:
    """Replace the forces k e + c edot of the last evaluation in load (nb, n) by `forces`.

    Parameters
    ----------
    forces : (n_r,) by row of layout.newton; only those of elements are used
    gamma : (n_r,), of which elements: forces - (k e + c edot)
    """
    layout = model.layout
    first = model.n_constraint + layout.added_start[model.n_body]
    for e in range(model.force_kind.shape[0]):
        count, begin = element_rows_at(model, work, e), first + layout.element_start[e]
        for k in range(count):
            gamma[begin + k] = forces[begin + k] - work.element_used[k, FORCE]
        for side in range(2):
            marker = model.force_marker[e, side]
            body = model.marker_body[marker]
            if body >= 0 and count > 0:
                for j in range(6):
                    push = 0.0
                    for k in range(count):
                        push += work.element_used[k, 6 * side + j] * gamma[begin + k]
                    for b in range(layout.size[body]):
                        load[body, b] -= work.J_m[marker, j, b] * push


@lean
def start_forces(model: Model, work: Workspace, forces: Array) -> None:
    """Fill the entries of elements in forces (n_r,) with k e + c edot of the last evaluation.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    forces : multipliers and element forces (n_r,), filled at the elements
    """
    first = model.n_constraint + model.layout.added_start[model.n_body]
    for e in range(model.force_kind.shape[0]):
        count, begin = element_rows_at(model, work, e), first + model.layout.element_start[e]
        for k in range(count):
            forces[begin + k] = work.element_used[k, FORCE]


@lean
def residual(
    model: Model, workspace: Any, t: float, multipliers: Array, load: Array, gamma: Array, r: Array
) -> float:
    """Evaluate a stage at t and fill the residuals of rates and multipliers; return the power [W].

    Parameters
    ----------
    workspace : memory of the run, with the state `stage` and its `rate`
    multipliers : (n_r,) of constraints, and forces of elements
    load : (nb, n), f - M vdot - Phi_q' lambda
    gamma : (n_r,), gamma - Phi_q vdot, with the feedback of Baumgarte's treatment, and the
        residuals of the laws of force elements
    r : (n,), of which positions: G v - qdot, and auxiliary states: their law less zdot
    """
    work, y, rate = workspace.work, workspace.stage, workspace.rate
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
    inertia_residual(model, work, rate, multipliers, work.f, load, gamma)
    if model.layout.element_row.shape[0] > 0:
        element_residual(model, work, multipliers, load, gamma)
    power = work.power[0]
    for k in range(model.n_constraint):
        power += multipliers[k] * work.rows[k, PHI_T]
    return power


@inlined
def inertia_residual(
    model: Model, of: Any, rate: Array, multipliers: Array, f: Array, load: Array, gamma: Array
) -> None:
    """load = f - M vdot - Phi_q' lambda (nb, n); gamma -= Phi_q vdot.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    of : with M and J: mass matrices (nb, n, n) and Jacobians (nb, n, r) by bodies
    rate : dy/dt (n,)
    multipliers : multipliers and element forces (n_r,)
    f : forces by bodies (nb, n)
    load : residual of the motion by bodies (nb, n), to fill
    gamma : right-hand sides of the rows (n_r,), reduced
    """
    layout, row_start, body_row = model.layout, model.layout.row_start, model.layout.body_row
    M, J = of.M, of.J
    for i in range(layout.size.shape[0]):
        n, j = layout.size[i], model.n_pos + model.vel_start[i]
        first = row_start[i]
        count = row_start[i + 1] - first
        for k in range(n):
            a = rate[j + k]
            s = f[i, k] - M[i, k, k] * a
            for b in range(min(k, layout.lead[i])):
                s -= M[i, k, b] * rate[j + b]
                load[i, b] -= M[i, k, b] * a
            for p in range(count):
                row = body_row[first + p]
                s -= J[i, k, p] * multipliers[row]
                gamma[row] -= J[i, k, p] * a
            load[i, k] = s
