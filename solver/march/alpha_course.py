"""Memory of a compiled step loop of generalized-alpha, and the numbers of its scheme."""

from typing import NamedTuple

import numpy as np

from ..compiled import jit
from ..model import Model
from ..package.schema import Array, IntArray
from ..workspace import Work, new_work
from .pencil import Frozen, Pencil, new_frozen, new_pencil

# Entries of `clock`: time, next step, last step, power at the ends of the last step.
TIME, NEXT, TAKEN, POWER, POWER_LAST = 0, 1, 2, 3, 4


class Scheme(NamedTuple):
    """Coefficients for one spectral radius rho at infinity."""

    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float
    to_v: float  # z enters the velocity at the end times this over h
    to_a: float  # and the acceleration times this over h^2
    error_q: float  # local error of positions [h^3 vddot]
    error_v: float  # and velocities [h^3 vdddot]
    stabilised: bool  # ggl: positions and velocities both satisfy their constraints


def scheme(rho: float, *, stabilised: bool) -> Scheme:
    """Return the scheme of spectral radius rho, 0 to 1 (integrate/generalized_alpha.py)."""
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    lag = alpha_m - alpha_f
    gamma = 0.5 - lag
    beta = 0.25 * (gamma + 0.5) ** 2
    return Scheme(
        alpha_m,
        alpha_f,
        gamma,
        beta,
        gamma / beta,
        (1 - alpha_m) / (beta * (1 - alpha_f)),
        abs(beta + 0.5 * lag - 1 / 6),
        abs(1 / 12 - 0.5 * lag * lag),
        stabilised,
    )


class AlphaCourse(NamedTuple):
    """Memory of a run. Rates are laid out as y: their velocity entries are accelerations."""

    work: Work
    frozen: Frozen
    real: Pencil
    y: Array  # (n,) state
    rate: Array  # (n,) its rate
    y_old: Array  # (n,) at the beginning of the last step
    rate_old: Array  # (n,)
    a: Array  # (n_vel,) the algorithm's acceleration, which runs behind
    multipliers: Array  # (n_c,)
    v_dd: Array  # (n_vel,) rate of the acceleration over the last step
    # the end of the step, under Newton's iteration
    stage: Array  # (n,)
    stage_rate: Array  # (n,)
    stage_a: Array  # (n_vel,)
    stage_multipliers: Array  # (n_c,)
    z: Array  # (n_vel,) step
    shift: Array  # (n_vel,) by the position multiplier
    step: Array  # (n_vel,) one correction, or an error
    change: Array  # (n_vel,)
    both: Array  # (n,) the same in the coordinates of y
    weight: Array  # (n,)
    zero: Array  # (nb, n)
    no_load: Array  # (n_c,)
    clock: Array  # (5,)
    counts: IntArray  # (6,) see course.py


@jit
def new_alpha_course(
    model: Model, t: float, y: Array, rate: Array, multipliers: Array, first_step: float
) -> AlphaCourse:
    """Return memory for a run from state y (n,) at t [s], with its rate and multipliers (n_c,)."""
    n, n_c, n_vel = y.shape[0], model.n_constraint, model.n_vel
    course = AlphaCourse(
        new_work(model),
        new_frozen(model),
        new_pencil(model, 1.0),
        y.copy(),
        rate.copy(),
        y.copy(),
        rate.copy(),
        rate[model.n_pos : model.n_pos + n_vel].copy(),
        multipliers.copy(),
        np.zeros(n_vel),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n_vel),
        np.zeros(n_c),
        np.zeros(n_vel),
        np.zeros(n_vel),
        np.zeros(n_vel),
        np.zeros(n_vel),
        np.zeros(n),
        np.zeros(n),
        np.zeros((model.n_body, model.plan.widest)),
        np.zeros(n_c),
        np.zeros(5),
        np.zeros(6, dtype=np.int64),
    )
    course.clock[TIME], course.clock[NEXT] = t, first_step
    course.clock[POWER] = rate[n - 1]
    return course
