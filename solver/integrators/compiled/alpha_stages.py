"""Generalized-alpha: coefficients, memory, and parts of a step (prediction, error, end)."""

from typing import Annotated, NamedTuple

import numpy as np

from ...dynamics.elements.floating_frame import flatten, inflate, row_products
from ...dynamics.evaluation.accelerations import accelerate, derivative_into
from ...dynamics.evaluation.elimination import solve
from ...dynamics.evaluation.evaluation import evaluate
from ...dynamics.model.coordinates import move, rates_into
from ...dynamics.model.model import PHI_T, Model, Workspace, new_workspace
from ...errors import did_you_mean
from ...math.arrays import Array, IntArray, zeros_of
from ...math.compiled import inlined, lean, structure
from .pencil import Frozen, Pencil, fed_back, new_frozen, new_pencil
from .residual import inertia_residual, start_forces
from .step_control import (
    EVALUATIONS,
    N_CLOCK,
    N_COUNT,
    NEXT,
    OTHER,
    SINCE,
    TAKEN,
    TIME,
    Options,
    norm,
    set_weights,
)

FORMULATIONS = ("ggl", "index3")
SPECTRAL_RADIUS = 0.8  # at infinity, by default
SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 2.0
HYSTERESIS = 1.2  # a change of step disturbs index 3: not for less than this
MAX_ITERATIONS = 8
TOLERANCE = 0.05  # of the local error allowed, left over by Newton's iteration
SMALL = 1e-3  # part of it: corrections that do not fall any more are rounding
# Entries of `clock` after those of every loop (step_control.py): power at the ends of the last
# step, and in the middle of one without a step before.
POWER, POWER_LAST = 3, 4


@structure
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
    lag: float  # of the algorithm's acceleration behind the step, over the change in the step


def scheme(formulation: str, rho: float) -> Scheme:
    """Return the scheme of spectral radius rho, 0 to 1 (integrators/generalized_alpha.py).

    Raises
    ------
    ValueError : another formulation or spectral radius; the message names it
    """
    if formulation not in FORMULATIONS:
        raise ValueError(
            f"formulation: expected one of {', '.join(FORMULATIONS)}, got {formulation!r}"
            f"{did_you_mean(formulation, FORMULATIONS)}"
        )
    if not 0.0 <= rho <= 1.0:
        raise ValueError(f"spectral_radius: expected a number from 0 to 1, got {rho!r}")
    rho = float(rho)
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = 0.5 - (alpha_m - alpha_f)
    return _scheme(alpha_m, alpha_f, gamma, 0.25 * (gamma + 0.5) ** 2, 0.0, formulation)


def first_scheme(formulation: str, rho: float) -> Scheme:
    """Return the scheme of a step without one before, whose algorithm's acceleration is not known.

    The one that a smooth motion has, in both ends of the step by the change of the acceleration in
    it: the trapezoidal rule. Without it, the velocity would be off by h^2 / 2 (gamma - 1/2) vddot.
    """
    usual = scheme(formulation, rho)
    lag = usual.alpha_m - usual.alpha_f
    return _scheme(0.0, 0.0, 0.5, usual.beta + 0.5 * lag, lag, formulation)


def _scheme(
    alpha_m: float, alpha_f: float, gamma: float, beta: float, lag: float, formulation: str
) -> Scheme:
    apart = alpha_m - alpha_f
    return Scheme(
        alpha_m,
        alpha_f,
        gamma,
        beta,
        gamma / beta,
        (1 - alpha_m) / (beta * (1 - alpha_f)),
        abs(beta + 0.5 * apart - 1 / 6),
        abs(1 / 12 - 0.5 * apart * apart),
        formulation == "ggl",
        lag,
    )


@structure
class AlphaWorkspace(NamedTuple):
    """Memory of a run. Rates are laid out as y: their velocity entries are accelerations."""

    work: Workspace
    frozen: Frozen
    real: Pencil
    y: Array  # (n,) state
    rate: Annotated[Array, "n"]  # its rate
    y_old: Array  # (n,) at the beginning of the last step
    rate_old: Annotated[Array, "n"]
    a: Annotated[Array, "n_vel"]  # the algorithm's acceleration, which runs behind
    # by row of layout.newton: of constraints, and forces of elements
    multipliers: Annotated[Array, "n_r"]
    v_dd: Annotated[Array, "n_vel"]  # rate of the acceleration over the last step
    # the end of the step, under Newton's iteration
    stage: Annotated[Array, "n"]
    stage_rate: Annotated[Array, "n"]
    stage_a: Annotated[Array, "n_vel"]
    stage_multipliers: Annotated[Array, "n_r"]
    z: Annotated[Array, "n_vel"]  # step
    shift: Annotated[Array, "n_vel"]  # by the position multiplier
    step: Annotated[Array, "n_vel"]  # one correction, or an error
    change: Annotated[Array, "n_vel"]
    both: Annotated[Array, "n"]  # the same in the coordinates of y
    weight: Annotated[Array, "n"]
    zero: Annotated[Array, "nb, widest"]
    no_load: Annotated[Array, "n_c"]
    clock: Annotated[Array, "clock"]
    counts: Annotated[IntArray, "count"]  # see step_control.py
    # of what is no part of a step: joints closed at output times
    apart: Annotated[IntArray, "count"]


def new_alpha_workspace(model: Model, t: float, y: Array, first_step: float) -> AlphaWorkspace:
    """Return memory for a run from state y (n,) at t [s], which `restart_alpha` begins.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    first_step : size of the first step [s]
    """
    n, n_c, n_vel = y.shape[0], model.n_constraint, model.n_vel
    n_r = model.layout.newton.place.shape[0]
    sizes = {"n": n, "n_c": n_c, "n_vel": n_vel, "n_r": n_r, "nb": model.n_body}
    sizes |= {"widest": model.layout.widest, "clock": N_CLOCK, "count": N_COUNT}
    workspace = zeros_of(
        AlphaWorkspace,
        sizes,
        work=new_workspace(model),
        frozen=new_frozen(model),
        real=new_pencil(model, 1.0),
        y=y.copy(),
        y_old=y.copy(),
    )
    workspace.clock[TIME], workspace.clock[NEXT] = t, first_step
    workspace.clock[SINCE], workspace.clock[OTHER] = t, np.inf
    return workspace


def restart_alpha(model: Model, workspace: AlphaWorkspace, t: float) -> None:
    """Forget what was before the state at t [s], and evaluate it.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    workspace : memory of the run
    t : time [s]
    """
    rate = workspace.rate
    derivative_into(model, workspace.work, t, workspace.y, rate)
    workspace.a[:], workspace.v_dd[:] = rate[model.n_pos : model.n_pos + model.n_vel], 0.0
    workspace.clock[POWER], workspace.clock[TAKEN] = rate[-1], 0.0
    workspace.multipliers[: model.n_constraint] = workspace.work.multipliers
    start_forces(model, workspace.work, workspace.multipliers)


@inlined
def predict(model: Model, scheme: Scheme, workspace: AlphaWorkspace, h: float) -> None:
    """Begin Newton's iteration: accelerations go on as over the last step.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    scheme : coefficients of the method
    workspace : memory of the run
    h : step size [s]
    """
    n_pos, last = model.n_pos, workspace.clock[TAKEN]
    alpha_m, alpha_f, gamma, beta = scheme.alpha_m, scheme.alpha_f, scheme.gamma, scheme.beta
    ratio = h / last if last > 0.0 else 1.0
    for i in range(model.n_vel):
        v, v_d = workspace.y[n_pos + i], workspace.rate[n_pos + i]
        a_0 = workspace.a[i]
        if last > 0.0:
            # The lag of a smooth motion is proportional to the step. What a jump has left in it
            # changes its sign in each step: scaled up, it would make the velocity swing more and
            # more, which no error estimate sees.
            due = (alpha_m - alpha_f) * last * workspace.v_dd[i]
            a_0 = v_d + ratio * due + min(ratio, 1.0 / ratio) * (a_0 - v_d - due)
        v_d1 = v_d + h * workspace.v_dd[i]
        a_1 = ((1.0 - alpha_f) * v_d1 + alpha_f * v_d - alpha_m * a_0) / (1.0 - alpha_m)
        workspace.z[i] = h * v + h * h * ((0.5 - beta) * a_0 + beta * a_1)
        workspace.shift[i] = 0.0
        workspace.stage[n_pos + i] = v + h * ((1.0 - gamma) * a_0 + gamma * a_1)
        workspace.stage_rate[n_pos + i] = v_d1
        workspace.stage_a[i] = a_1
    workspace.stage[n_pos + model.n_vel] = workspace.y[n_pos + model.n_vel]
    for k in range(workspace.multipliers.shape[0]):
        workspace.stage_multipliers[k] = workspace.multipliers[k]


@inlined
def place(model: Model, workspace: AlphaWorkspace) -> None:
    """Fill the positions of workspace.stage: the last state's, moved by z + shift."""
    for i in range(model.n_vel):
        workspace.step[i] = workspace.z[i] + workspace.shift[i]
    for i in range(model.n_pos):
        workspace.stage[i] = workspace.y[i]
    move(model, workspace.stage, workspace.step)


@inlined
def correction_size(model: Model, options: Options, workspace: AlphaWorkspace) -> float:
    """Size of `step` of positions and `change` of velocities in units of tolerance.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    options : tolerances and options of the run (step_control.py)
    workspace : memory of the run
    """
    n_pos, stage, both = model.n_pos, workspace.stage, workspace.both
    # rates_into takes the velocities of a state for the step
    for i in range(model.n_vel):
        both[n_pos + i] = stage[n_pos + i]
        stage[n_pos + i] = workspace.step[i]
    rates_into(model, stage, both)
    for i in range(model.n_vel):
        stage[n_pos + i] = both[n_pos + i]
        both[n_pos + i] = workspace.change[i]
    both[n_pos + model.n_vel] = 0.0
    return norm(options, both, workspace.weight)


@lean
def middle_rates(model: Model, workspace: AlphaWorkspace, t: float, h: float) -> None:
    """Fill `change` with the second rates of velocities in a step of h from t, by its middle.

    Of a step without one before, with which its rates could be compared. Leaves the last evaluation
    at the end of the step.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    workspace : memory of the run
    t : begin of the step [s]
    h : step size [s]
    """
    work, middle, n_pos = workspace.work, workspace.both, model.n_pos
    rates_into(model, workspace.stage, workspace.stage_rate)
    for i in range(workspace.y.shape[0]):
        swing = 0.125 * h * (workspace.rate[i] - workspace.stage_rate[i])
        middle[i] = 0.5 * (workspace.y[i] + workspace.stage[i]) + swing
    evaluate(model, work, t + 0.5 * h, middle)
    accelerate(model, work, t + 0.5 * h, middle, False)
    flatten(model, work.acceleration, workspace.change, 0)
    for i in range(model.n_vel):
        ends = workspace.rate[n_pos + i] + workspace.stage_rate[n_pos + i]
        workspace.change[i] = 4.0 * (ends - 2.0 * workspace.change[i]) / h**2
    workspace.clock[POWER_LAST] = driving_power(model, work)
    evaluate(model, work, t + h, workspace.stage)
    workspace.counts[EVALUATIONS] += 2


@inlined
def local_error(
    model: Model, options: Options, scheme: Scheme, workspace: AlphaWorkspace, h: float
) -> float:
    """Local error of positions and velocities.

    h^3 (beta + (alpha_m - alpha_f) / 2 - 1/6) vddot and
    h^3 (1/12 - (alpha_m - alpha_f)^2 / 2) vdddot; both pass the step's own matrix, which
    takes out what is stiff or against the constraints and damped there anyway. What the
    constraints prescribe is exact at the end of the step, but a cubic within it, off by
    h^4 vdddot / 384.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    options : tolerances and options of the run (step_control.py)
    scheme : coefficients of the method
    workspace : memory of the run
    h : step size [s]
    """
    n_pos, n_vel, last, real = model.n_pos, model.n_vel, workspace.clock[TAKEN], workspace.real
    frozen, factors, layout = workspace.frozen, workspace.real.factors, model.layout
    rest = workspace.no_load
    both, s, feeds = workspace.both, scheme.to_v / h, model.quantities.feedback.shape[0] > 0
    for i in range(n_vel):
        v_dd = (workspace.stage_rate[n_pos + i] - workspace.rate[n_pos + i]) / h
        both[n_pos + i] = -scheme.to_a * h**3 * scheme.error_q * v_dd
        if last > 0.0:  # else by `middle_rates`
            workspace.change[i] = 2.0 * (v_dd - workspace.v_dd[i]) / (h + last)
    real.gamma[:] = 0.0
    inertia_residual(model, frozen, both, rest, workspace.zero, real.load, real.gamma)
    real.gamma[:] = 0.0
    solve(layout, layout.newton, factors, real.load, real.gamma, real.x, real.mu)
    if feeds:
        fed_back(model, frozen, real, s, real.x, workspace.zero)
    flatten(model, real.x, workspace.step, 0)
    for i in range(n_vel):
        both[n_pos + i] = -scheme.to_a * h**3 * scheme.error_v * workspace.change[i]
    inertia_residual(model, frozen, both, rest, workspace.zero, real.load, real.gamma)
    # what the constraints prescribe is exact at the end, but a cubic within the step
    inflate(model, workspace.change, 0, real.x)
    real.gamma[:] = 0.0
    solve(layout, layout.newton, factors, real.load, real.gamma, real.rho, real.mu)
    if feeds:
        fed_back(model, frozen, real, s, real.rho, workspace.zero)
    row_products(model, frozen.J, real.x, real.gamma)
    flatten(model, real.rho, workspace.change, 0)
    solve(layout, layout.newton, factors, workspace.zero, real.gamma, real.x, real.mu)
    if feeds:
        fed_back(model, frozen, real, s, real.x, workspace.zero)
    for i in range(model.n_body):
        j = model.vel_start[i]
        for k in range(layout.size[i]):
            prescribed = abs(real.x[i, k]) * h**4 / 384.0
            workspace.step[j + k] = abs(workspace.step[j + k]) + prescribed
    set_weights(options, workspace.y, workspace.stage, workspace.weight)
    return correction_size(model, options, workspace)


@inlined
def driving_power(model: Model, work: Workspace) -> float:
    """Return the power of drives and forces at the last evaluation and its multipliers [W]."""
    power = work.power[0]
    for k in range(model.n_constraint):
        power += work.multipliers[k] * work.rows[k, PHI_T]
    return float(power)


@inlined
def bent_work(workspace: AlphaWorkspace, h: float, power: float) -> float:
    """Return the work by a parabola of the power, less that by the trapezoidal rule [J].

    The parabola goes through the ends of this step and the beginning of the last one; without a
    last one, through the middle of this step.

    Parameters
    ----------
    workspace : memory of the run
    h : step size [s]
    power : power of drives and dampers at the end of the step [W]
    """
    clock, last = workspace.clock, workspace.clock[TAKEN]
    if not last > 0.0:
        return float(h / 3.0 * (2.0 * clock[POWER_LAST] - clock[POWER] - power))
    slope = (power - clock[POWER]) / h - (clock[POWER] - clock[POWER_LAST]) / last
    return float(-(h**3) / 6.0 * slope / (h + last))


@inlined
def accept(model: Model, scheme: Scheme, workspace: AlphaWorkspace, h: float, power: float) -> None:
    """Make the end of the step the state.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    scheme : coefficients of the method
    workspace : memory of the run
    h : step size [s]
    power : power of drives and dampers at the end of the step [W]
    """
    clock, n_pos, n = workspace.clock, model.n_pos, workspace.y.shape[0] - 1
    work = 0.5 * h * (clock[POWER] + power) + bent_work(workspace, h, power)
    clock[POWER_LAST], clock[POWER] = clock[POWER], power
    workspace.stage[n] = workspace.y[n] + work
    rates_into(model, workspace.stage, workspace.stage_rate)
    workspace.stage_rate[n] = power
    for i in range(model.n_vel):
        j = n_pos + i
        change = workspace.stage_rate[j] - workspace.rate[j]
        workspace.v_dd[i] = change / h
        workspace.a[i] = workspace.stage_a[i] + scheme.lag * change
    for i in range(n + 1):
        workspace.y_old[i], workspace.y[i] = workspace.y[i], workspace.stage[i]
        workspace.rate_old[i], workspace.rate[i] = workspace.rate[i], workspace.stage_rate[i]
    for k in range(workspace.multipliers.shape[0]):
        workspace.multipliers[k] = workspace.stage_multipliers[k]


@inlined
def interpolate(workspace: AlphaWorkspace, h: float, x: float, out: Array) -> None:
    """Fill out (n,) with the cubic through both ends of the last step at its part x, 0 to 1.

    Parameters
    ----------
    workspace : memory of the run
    h : step size [s]
    x : part of the step, 0 to 1
    out : state there (n,), to fill
    """
    rise, bent = x * x * (3.0 - 2.0 * x), x * (1.0 - x) * h
    for i in range(out.shape[0]):
        out[i] = (1.0 - rise) * workspace.y_old[i] + rise * workspace.y[i]
        out[i] += bent * ((1.0 - x) * workspace.rate_old[i] - x * workspace.rate[i])
