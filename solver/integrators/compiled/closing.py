"""Bring the end of an implicit step back onto the constraints, without exciting stiff modes.

The metric is that of the step, s^2 M + s D + K: a change in the metric of the mass alone
(projection.py) would take what little mass a stiff mode has near a joint, and leave it swinging.

    (s^2 M + s D + K) x + Phi_q' mu = 0,   Phi_q x = -Phi,

and the same for velocities with Phi_q dv = -Phidot.
"""

from typing import Any

from ...dynamics.analysis.projection import rounding
from ...dynamics.elements.floating_frame import flatten, largest
from ...dynamics.evaluation.elimination import solve
from ...dynamics.evaluation.evaluation import evaluate, evaluate_rates, largest_left
from ...dynamics.model.coordinates import move
from ...dynamics.model.model import PHI, Model
from ...dynamics.tolerances import SPARED, STAYS_CLOSED_TO
from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, lean
from .pencil import Pencil, factorise_pencil, freeze
from .step_control import EVALUATIONS, FACTORISATIONS, JACOBIANS

MAX_ITERATIONS = 4
SETTLED = 1e-12  # last change of velocities with softened rows [m/s, rad/s]
SMALL = 1e-7  # change of positions whose square is below rounding [m, rad]


@lean
def close(model: Model, workspace: Any, s: float, t: float, y: Array, counts: IntArray) -> bool:
    """Move y (n,) onto the constraints, in place; return whether that has succeeded.

    `frozen` and `real` of the workspace are filled again; `counts` as in step_control.py.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    workspace : memory of a run, of which work, frozen and real are used
    s : rate per change, of the method over the step size [1/s]
    t : time [s]
    y : state (n,), moved in place
    counts : counters of the run (step_control.py)
    """
    n_pos, n_vel = model.n_pos, model.n_vel
    work, frozen, real = workspace.work, workspace.frozen, workspace.real
    evaluate(model, work, t, y)
    counts[EVALUATIONS] += 1
    violation, closed, moved = largest(work.rows[:, PHI]), rounding(model, y), 0.0
    real.load[:] = 0.0
    if not violation <= closed:
        for _ in range(MAX_ITERATIONS):
            before = violation
            freeze(model, work, t, y, frozen)
            factorise_pencil(model, frozen, real, s * s, s, 1.0)
            counts[JACOBIANS] += 1
            counts[FACTORISATIONS] += 1
            for k in range(model.n_constraint):
                real.gamma[k] = -work.rows[k, PHI]
            moved = _answered(model, real)
            move(model, y, real.delta)
            if moved < SMALL:
                violation = max(moved * moved, largest_left(model, work, frozen.J, real.x))
                if violation <= closed:
                    break
            evaluate(model, work, t, y)
            counts[EVALUATIONS] += 1
            violation = largest(work.rows[:, PHI])
            if violation <= closed or violation * moved <= SPARED * closed * before:
                break
            # rounding is larger than usual
            if before < STAYS_CLOSED_TO and not violation < 0.5 * before:
                break
    if moved == 0.0:
        freeze(model, work, t, y, frozen)
        factorise_pencil(model, frozen, real, s * s, s, 1.0)
        counts[JACOBIANS] += 1
        counts[FACTORISATIONS] += 1
    for _ in range(MAX_ITERATIONS):
        evaluate_rates(model, work, y)
        for k in range(model.n_constraint):
            real.gamma[k] = -work.left[k]
        changed = _answered(model, real)
        for i in range(n_vel):
            y[n_pos + i] += real.delta[i]
        # Softened rows take a part of what they miss, all others all of it.
        if frozen.softness[0] == 0.0 or changed < SETTLED:
            break
    return violation < STAYS_CLOSED_TO


@inlined
def _answered(model: Model, real: Pencil) -> float:
    """Fill delta[:n_vel] with the least motion that changes rows by gamma; return its size."""
    layout = model.layout
    solve(layout, layout.newton, real.factors, real.load, real.gamma, real.x, real.mu)
    flatten(model, real.x, real.delta, 0)
    return largest(real.delta[: model.n_vel])
