"""Projection of a state onto the constraints in the metric of the mass."""

import numpy as np

from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, lean, rebound
from ..elements.floating_frame import flatten, largest
from ..evaluation.accelerations import by_blocks, dense, factorise_mass, solve_dense, solve_mass
from ..evaluation.energies import momenta_into
from ..evaluation.evaluation import evaluate, evaluate_rates
from ..model.coordinates import move
from ..model.model import PHI, Model, Workspace, spare_workspace
from ..tolerances import CLOSED, SAME_VELOCITIES, SPARED, STAYS_CLOSED_TO

# Given velocities are kept by a large inertia: a change of the others moves them by about 1 / HOLD.
# They are then reset to the given values, and the next pass removes the residual of this.
HOLD = 1e6
MOST_PASSES = 40


def least_energy(model: Model, t: float, y: Array, given: IntArray, values: Array) -> Array:
    """Return velocities v (n_vel,) of least v' M v with Phi_q v = -Phi_t and v[given] = values.

    Linear in the number of bodies. For independent constraints; the result violates them where
    `values` contradict them.

    Parameters
    ----------
    y : (n,) a state at time t; its velocities do not matter
    given, values : (k,) numbers among the velocities, and their values
    """
    held = np.zeros(model.n_vel, dtype=np.int64)
    held[given] = 1
    start = np.zeros_like(y)
    start[: model.n_pos] = y[: model.n_pos]
    v = start[model.n_pos : model.n_pos + model.n_vel]
    v[given] = values
    _correct(model, spare_workspace(model), t, start, held, np.zeros_like(y), np.zeros(model.n_vel))
    return v.copy()


@lean
def _correct(
    model: Model, work: Workspace, t: float, y: Array, held: IntArray, moved: Array, change: Array
) -> None:
    """Replace the velocities in y (n,) that are not held (n_vel,) by those of least energy.

    `moved` (n,), zeros, and `change` (n_vel,) are memory.
    """
    evaluate(model, work, t, y)
    momenta_into(model, work, y, change)
    _load(model, work, held, -1.0, change)
    for i in range(model.n_body):
        for k in range(model.layout.size[i]):
            if held[model.vel_start[i] + k] > 0:
                work.M[i, k, k] *= HOLD
    factorise_mass(model, work)
    for _ in range(MOST_PASSES):
        evaluate_rates(model, work, y)
        for k in range(model.n_constraint):
            work.gamma[k] = -work.left[k]
        solve_mass(model, work)
        flatten(model, work.acceleration, change, 0)
        before = largest(y[model.n_pos :])
        for k in range(held.shape[0]):
            if held[k] > 0:
                moved[model.n_pos + k] = change[k]
                change[k] = 0.0
            else:
                y[model.n_pos + k] += change[k]
        if not largest(change) > SAME_VELOCITIES * before:
            break
        momenta_into(model, work, moved, change)
        _load(model, work, held, 1.0, change)


@inlined
def _load(model: Model, work: Workspace, held: IntArray, sign: float, momenta: Array) -> None:
    """Fill work.load with `momenta` (n_vel,) times `sign`; nothing where velocities are held."""
    for i in range(model.n_body):
        v = model.vel_start[i]
        for k in range(model.layout.size[i]):
            work.load[i, k] = 0.0 if held[v + k] > 0 else sign * momenta[v + k]


MAX_ITERATIONS = 6


@lean
def rounding(model: Model, y: Array) -> float:
    """Return the |Phi| [m, rad] of a state y (n,) that needs no correction."""
    return CLOSED * max(1.0, largest(y[: model.n_pos]))


@lean
def project(model: Model, work: Workspace, t: float, y: Array, step: Array, before: Array) -> bool:
    """Move y (n,) onto the constraints, in place; return whether that succeeded.

    Positions: minimise dq' M dq / 2 subject to Phi(q + dq) = 0, by Newton's method;
    M dq + Phi_q' mu = 0, Phi_q dq = -Phi. Velocities: M dv + Phi_q' nu = 0,
    Phi_q dv = -Phidot, which by Gauss takes away kinetic energy only. Euler parameters come
    out with length one.

    Parameters
    ----------
    step, before : (n_vel,), (n_pos,) memory
    """
    n_pos, n_vel, n_c = model.n_pos, model.n_vel, model.n_constraint
    step[:] = 0.0
    move(model, y, step)
    evaluate(model, work, t, y)
    violation, closed = largest(work.rows[:, PHI]), rounding(model, y)
    for _ in range(MAX_ITERATIONS):
        if not violation > closed:
            break
        for k in range(n_c):
            work.gamma[k] = -work.rows[k, PHI]
        _solve_row_change(model, work, step)
        for i in range(n_pos):
            before[i] = y[i]
        move(model, y, step)
        evaluate(model, work, t, y)
        left = largest(work.rows[:, PHI])
        if not left < violation:
            for i in range(n_pos):
                y[i] = before[i]
            evaluate(model, work, t, y)
            break
        # Newton's next correction is to this one as the violation left is to the one before.
        spared = left * largest(step) <= SPARED * closed * violation
        violation = left
        if spared:
            break
    evaluate_rates(model, work, y)
    for k in range(n_c):
        work.gamma[k] = -work.left[k]
    _solve_row_change(model, work, step)
    for i in range(n_vel):
        y[n_pos + i] += step[i]
    return bool(violation < STAYS_CLOSED_TO)


@lean
def _solve_row_change(model: Model, work: Workspace, step: Array) -> None:
    """Fill step (n_vel,) with the least motion that changes the constraints by work.gamma."""
    work.load[:] = 0.0
    factorise_mass(model, work)
    solve_mass(model, work)
    flatten(model, work.acceleration, step, 0)


def _solve_dense_row_change(model: Model, work: Workspace, step: Array) -> None:
    """As `_solve_row_change` for any model, by dense linear algebra."""
    step[:], _ = solve_dense(model, dense(model, work), np.zeros(model.n_vel), work.gamma)


_dense_project = rebound(project, _solve_row_change=_solve_dense_row_change)


def projected(
    model: Model, t: float, y: Array, work: Workspace | None = None
) -> tuple[Array, bool]:
    """Return the state (n,) on the constraints nearest to y, and whether it was reached.

    For mechanisms with constraints. `work` is memory for reuse.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    work : memory for reuse; None: new memory
    """
    out = y.copy()
    method = project if by_blocks(model) else _dense_project
    step, before = np.empty(model.n_vel), np.empty(model.n_pos)
    return out, method(model, work or spare_workspace(model), t, out, step, before)
