"""Options, outcomes and limits of the compiled step loops; memory of that of Radau IIA."""

from typing import NamedTuple

import numpy as np

from ...dynamics.model import Model
from ...dynamics.system import evaluate
from ...dynamics.workspace import Work, new_work
from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, structure
from .elements import start_forces
from .pencil import Frozen, Pencil, new_frozen, new_pencil

# What a call comes back with; and, of an attempt refused, that a shorter one follows.
ARRIVED, PAUSED, TOO_SMALL, NOT_FINITE, REFUSED, GOES_ON = 0, 1, 2, 3, 4, 5
# Entries of `clock`: time, next step, last step; its error and Newton's rate of convergence; step
# of the last iteration that failed.
TIME, NEXT, TAKEN = 0, 1, 2
ERROR_LAST, RATE, LIMIT = 3, 4, 5
# Entries of `counts`.
STEPS, REJECTED, EVALUATIONS, FACTORISATIONS, BAD, TROUBLE = 0, 1, 2, 3, 4, 5
# Values of TROUBLE: why the last attempt was refused.
NONE, NEWTON, TOO_ROUGH, ILL, OFF = 0, 1, 2, 3, 4
SMALLEST = 1e-300  # step, whatever the time [s]
MAX_NOT_FINITE = 25  # attempts in a row


@structure
class Options(NamedTuple):
    """What does not change during a run."""

    t_end: float
    rtol: float
    atol: Array  # (n,)
    block_starts: IntArray  # (b + 1,) of the error norm
    max_step: float
    min_step: float
    fixed_step: float  # 0: error control
    closes: bool  # bring every step back onto the constraints


@structure
class Ends(NamedTuple):
    """Ends of the accepted steps of one call; without room for any where nobody asks for them."""

    t: Array  # (k,) [s]
    y: Array  # (k, n)


@inlined
def keep_end(ends: Ends, k: int, t: float, y: Array) -> None:
    """Keep the end of step k of a call."""
    if k < ends.t.shape[0]:
        ends.t[k] = t
        for i in range(y.shape[0]):
            ends.y[k, i] = y[i]


@inlined
def next_step(options: Options, clock: Array) -> tuple[float, float, bool]:
    """Return the next step [s], its end, and whether it is too small to be taken.

    Within the largest step, on t_end exactly, no sliver before it.
    """
    t, h, stretch = clock[TIME], clock[NEXT], 1.01
    if options.fixed_step > 0.0:
        h, stretch = options.fixed_step, 1.0 + 1e-6
    h = min(h, options.max_step)
    if h * stretch >= options.t_end - t:
        return options.t_end - t, options.t_end, False
    return h, t + h, h < max(options.min_step, 2e-15 * abs(t), SMALLEST)


@inlined
def refuse(options: Options, clock: Array, counts: IntArray, h: float, shorter: float) -> int:
    """Count an attempt of h that failed, and leave the next size; say whether to go on.

    `shorter` is the factor of the next size where numbers are finite.
    """
    counts[REJECTED] += 1
    if options.fixed_step > 0.0:
        return REFUSED
    if counts[TROUBLE] == ILL:
        counts[BAD] += 1
        if counts[BAD] > MAX_NOT_FINITE:
            return NOT_FINITE
        shorter = 0.1
    clock[NEXT] = h * shorter
    return GOES_ON


@inlined
def count_step(clock: Array, counts: IntArray, h: float, t_new: float) -> None:
    """Count an accepted step of h to t_new."""
    clock[TAKEN], clock[TIME] = h, t_new
    counts[STEPS] += 1
    counts[BAD] = 0


@structure
class RadauWorkspace(NamedTuple):
    """Memory of a run, which a call takes up where the last one left it."""

    work: Work
    frozen: Frozen
    real: Pencil
    pair: Pencil
    y: Array  # (n,) state
    f: Array  # (n,) its rate
    y_old: Array  # (n,) state at the beginning of the last step
    Q: Array  # (3, n) polynomial of the last step
    Z: Array  # (3, n) changes at the stages
    multipliers: Array  # (3, n_r) at the stages, by row of plan.newton
    multipliers_old: Array  # (3, n_r) at those of the last step
    predicted: Array  # (3, n_r) at the stages, before the iteration
    power: Array  # (3,) at the stages [W]
    load: Array  # (3, nb, n) what the stages leave: forces,
    gamma: Array  # (3, n_r) constraints and laws of elements
    r: Array  # (3, n) and kinematics
    stage: Array  # (n,)
    rate: Array  # (n,) at a stage
    weight: Array  # (n,)
    clock: Array  # (6,)
    counts: IntArray  # (6,)


def new_radau_workspace(
    model: Model, t: float, y: Array, rate: Array, multipliers: Array, first_step: float
) -> RadauWorkspace:
    """Return memory for a run from state y (n,) at t [s], with its rate and multipliers (n_c,)."""
    n, nb, widest = y.shape[0], model.n_body, model.plan.widest
    n_r = model.plan.newton.place.shape[0]
    course = RadauWorkspace(
        new_work(model),
        new_frozen(model),
        new_pencil(model, 1.0),
        new_pencil(model, 1.0 + 0.0j),
        y.copy(),
        rate.copy(),
        y.copy(),
        np.zeros((3, n)),
        np.zeros((3, n)),
        np.zeros((3, n_r)),
        np.zeros((3, n_r)),
        np.zeros((3, n_r)),
        np.zeros(3),
        np.zeros((3, nb, widest)),
        np.zeros((3, n_r)),
        np.zeros((3, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(6),
        np.zeros(6, dtype=np.int64),
    )
    course.clock[TIME], course.clock[NEXT], course.clock[ERROR_LAST] = t, first_step, 1.0
    course.clock[RATE], course.clock[LIMIT] = 1.0, 1e300
    evaluate(model, course.work, t, y)
    for k in range(3):
        course.multipliers_old[k, : model.n_constraint] = multipliers
        start_forces(model, course.work, course.multipliers_old[k])
    return course
