"""Memory of a compiled step loop of generalized-alpha."""

from typing import NamedTuple

import numpy as np

from ...dynamics.evaluation import evaluate
from ...dynamics.model import Model
from ...dynamics.workspace import Work, new_work
from ...math.arrays import Array, IntArray
from ...math.compiled import structure
from .elements import start_forces
from .pencil import Frozen, Pencil, new_frozen, new_pencil
from .step_control import N_CLOCK, N_COUNT, NEXT, OTHER, SINCE, TAKEN, TIME

# Entries of `clock` after those of every loop (step_control.py): power at the ends of the last
# step.
POWER, POWER_LAST = 3, 4


@structure
class AlphaWorkspace(NamedTuple):
    """Memory of a run. Rates are laid out as y: their velocity entries are accelerations."""

    work: Work
    frozen: Frozen
    real: Pencil
    y: Array  # (n,) state
    rate: Array  # (n,) its rate
    y_old: Array  # (n,) at the beginning of the last step
    rate_old: Array  # (n,)
    a: Array  # (n_vel,) the algorithm's acceleration, which runs behind
    multipliers: Array  # (n_r,) by row of plan.newton: of constraints, and forces of elements
    v_dd: Array  # (n_vel,) rate of the acceleration over the last step
    # the end of the step, under Newton's iteration
    stage: Array  # (n,)
    stage_rate: Array  # (n,)
    stage_a: Array  # (n_vel,)
    stage_multipliers: Array  # (n_r,)
    z: Array  # (n_vel,) step
    shift: Array  # (n_vel,) by the position multiplier
    step: Array  # (n_vel,) one correction, or an error
    change: Array  # (n_vel,)
    both: Array  # (n,) the same in the coordinates of y
    weight: Array  # (n,)
    zero: Array  # (nb, n)
    no_load: Array  # (n_c,)
    clock: Array  # (N_CLOCK,)
    counts: IntArray  # (N_COUNT,) see step_control.py
    apart: IntArray  # (N_COUNT,) of what is no part of a step: joints closed at output times


def new_alpha_workspace(
    model: Model, t: float, y: Array, rate: Array, multipliers: Array, first_step: float
) -> AlphaWorkspace:
    """Return memory for a run from state y (n,) at t [s], with its rate and multipliers (n_c,)."""
    n, n_c, n_vel = y.shape[0], model.n_constraint, model.n_vel
    n_r = model.plan.newton.place.shape[0]
    workspace = AlphaWorkspace(
        new_work(model),
        new_frozen(model),
        new_pencil(model, 1.0),
        y.copy(),
        rate.copy(),
        y.copy(),
        rate.copy(),
        rate[model.n_pos : model.n_pos + n_vel].copy(),
        np.zeros(n_r),
        np.zeros(n_vel),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n_vel),
        np.zeros(n_r),
        np.zeros(n_vel),
        np.zeros(n_vel),
        np.zeros(n_vel),
        np.zeros(n_vel),
        np.zeros(n),
        np.zeros(n),
        np.zeros((model.n_body, model.plan.widest)),
        np.zeros(n_c),
        np.zeros(N_CLOCK),
        np.zeros(N_COUNT, dtype=np.int64),
        np.zeros(N_COUNT, dtype=np.int64),
    )
    workspace.clock[TIME], workspace.clock[NEXT] = t, first_step
    workspace.clock[SINCE], workspace.clock[OTHER] = t, np.inf
    restart_alpha(model, workspace, t, y, rate, multipliers)
    return workspace


def restart_alpha(
    model: Model, workspace: AlphaWorkspace, t: float, y: Array, rate: Array, multipliers: Array
) -> None:
    """Forget what was before state y (n,) at t [s]; rate and multipliers are those after it."""
    workspace.y[:], workspace.rate[:], workspace.v_dd[:] = y, rate, 0.0
    workspace.a[:] = rate[model.n_pos : model.n_pos + model.n_vel]
    workspace.clock[POWER], workspace.clock[TAKEN] = rate[-1], 0.0
    workspace.multipliers[: model.n_constraint] = multipliers
    workspace.work.multipliers[:] = multipliers
    evaluate(model, workspace.work, t, y)
    start_forces(model, workspace.work, workspace.multipliers)
