"""Generalized-alpha on a Lie group: the step loop for mechanisms, compiled whole.

The method and its letters are those of `GeneralizedAlpha` (integrators/generalized_alpha.py);
matrices of Newton's iteration are those of pencil.py, made fresh with the first evaluation of each
step.
"""

import numpy as np

from ...dynamics.elements.floating_frame import flatten, inflate, row_products
from ...dynamics.evaluation.accelerations import accelerate
from ...dynamics.evaluation.elimination import solve
from ...dynamics.evaluation.evaluation import evaluate, evaluate_rates, largest_left
from ...dynamics.model.model import PHI, PHI_T, Model
from ...math.arrays import Array
from ...math.compiled import inlined, lean
from . import step_control as codes
from .alpha_stages import (
    HYSTERESIS,
    MAX_FACTOR,
    MAX_ITERATIONS,
    MIN_FACTOR,
    SAFETY,
    SMALL,
    TOLERANCE,
    AlphaWorkspace,
    Scheme,
    accept,
    bent_work,
    correction_size,
    driving_power,
    interpolate,
    local_error,
    middle_rates,
    place,
    predict,
)
from .closing import close
from .feedback import scale_feedback
from .pencil import factorise_feedback, factorise_pencil, fed_back, freeze
from .residual import element_residual, inertia_residual
from .step_control import (
    Ends,
    Options,
    at_kink,
    count_step,
    finite,
    keep_end,
    next_step,
    refuse,
    set_weights,
)
from .tension import judge, update_tension


@lean
def advance_alpha(
    model: Model,
    options: Options,
    usual: Scheme,
    first: Scheme,
    workspace: AlphaWorkspace,
    most_steps: int,
    times: Array,
    rows: Array,
    filled: int,
    ends: Ends,
) -> tuple[int, int]:
    """Take steps until END or `most_steps` accepted ones; see `advance` (radau_loop.py).

    `first` is the scheme of steps without one before, under error control.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    options : tolerances and options of the run (step_control.py)
    usual : coefficients of the method
    first : coefficients of steps without one before, under error control
    workspace : memory of the run
    most_steps : number of accepted steps after which the call returns
    times : output times (k,) [s]
    rows : solution at these times (k, n), to fill
    filled : number of rows filled before
    ends : memory of accepted step ends
    """
    clock, counts = workspace.clock, workspace.counts
    tightest = np.inf
    for i in range(options.atol.shape[0]):
        tightest = min(tightest, options.atol[i])
    opening = options.rtol + tightest  # of constraints after a correction
    taken, refused = 0, 0.0  # steps; the last that Newton's iteration refused, or 0
    while clock[codes.TIME] < clock[codes.END]:
        if taken == most_steps:
            return codes.PAUSED, filled
        t = clock[codes.TIME]
        if options.fixed_step == 0.0:
            clock[codes.NEXT] = min(clock[codes.NEXT], _longest(model, workspace.y, options.rtol))
        h, t_new, too_small = next_step(options, clock)
        if too_small:
            return codes.TOO_SMALL, filled

        if at_kink(options, clock):
            _forget_rates(model, workspace)
        scheme = usual if clock[codes.TAKEN] > 0.0 or options.fixed_step > 0.0 else first
        predict(model, scheme, workspace, h)
        _solve_end(model, options, scheme, workspace, t_new, h, refused, opening)
        factor = _estimate_error(model, options, scheme, workspace, h)
        power, factor = _estimate_work(model, options, workspace, t_new, h, factor)
        refused = h if counts[codes.TROUBLE] == codes.NEWTON else 0.0

        if counts[codes.TROUBLE] != codes.NONE:
            judge(clock)
            rough = counts[codes.TROUBLE] == codes.TOO_ROUGH
            factor = max(MIN_FACTOR, min(MAX_FACTOR, factor)) if rough else 0.25
            code = refuse(options, clock, counts, h, factor)
            if code != codes.GOES_ON:
                return code, filled
            continue

        accept(model, scheme, workspace, h, power)
        factor = max(MIN_FACTOR, min(MAX_FACTOR, factor))
        clock[codes.NEXT] = h if 1.0 <= factor < HYSTERESIS else h * factor
        count_step(clock, counts, h, t_new)
        judge(clock)
        keep_end(ends, taken, t_new, workspace.y)
        taken += 1
        filled = _fill_rows(model, scheme, workspace, t, h, times, rows, filled)
    return codes.ARRIVED, filled


@inlined
def _longest(model: Model, y: Array, rtol: float) -> float:
    """Return the longest step [s] in which outputs keep rtol where bodies turn steadily.

    The cubic through Euler parameters and their rates misses x^4 / 384; x is half the angle.
    """
    most = 0.0
    for i in range(model.n_body):
        j = model.n_pos + model.vel_start[i] + 3
        most = max(most, y[j] ** 2 + y[j + 1] ** 2 + y[j + 2] ** 2)
    return 2.0 * (384.0 * rtol) ** 0.25 / np.sqrt(most) if most > 0.0 else np.inf


@inlined
def _forget_rates(model: Model, workspace: AlphaWorkspace) -> None:
    """Forget what runs behind and what is extrapolated: behind a kink it is of other laws."""
    workspace.clock[codes.TAKEN] = 0.0
    for i in range(model.n_vel):
        workspace.a[i], workspace.v_dd[i] = workspace.rate[model.n_pos + i], 0.0


@inlined
def _solve_end(
    model: Model,
    options: Options,
    scheme: Scheme,
    workspace: AlphaWorkspace,
    t_new: float,
    h: float,
    refused: float,
    opening: float,
) -> None:
    """Solve for the end of the step by Newton's iteration; TROUBLE tells whether it has failed.

    Parameters
    ----------
    t_new, h : end and length of the step [s]
    refused : the last attempt, if Newton's iteration refused it [s]; else 0
    opening : largest velocity of constraints that a last correction may leave
    """
    counts, work, stage = workspace.counts, workspace.work, workspace.stage
    counts[codes.TROUBLE] = codes.NEWTON
    size_last, lawful = 0.0, False
    for k in range(model.quantities.along.shape[0]):
        lawful = lawful or model.quantities.along[k] >= 0
    for iteration in range(1, MAX_ITERATIONS + 1):
        place(model, workspace)
        for k in range(model.n_constraint):
            work.multipliers[k] = workspace.stage_multipliers[k]
        evaluate(model, work, t_new, stage)
        counts[codes.EVALUATIONS] += 1
        if iteration == 1:
            _make_matrix(model, scheme, workspace, t_new, h, refused)
            set_weights(options, workspace.y, stage, workspace.weight)
        _fill_residuals(model, scheme, workspace, h)
        _correct(model, scheme, workspace, h)
        size = correction_size(model, options, workspace)
        if not size < 1e300:
            if iteration == 1:  # later it is the iteration that runs away
                counts[codes.TROUBLE] = codes.ILL
            return
        rate = size / size_last if iteration > 1 and size_last > 0.0 else 0.0
        # the second correction may exceed the first: a prediction can be too good for its J
        if iteration > 2 and rate >= 1.0 and size > TOLERANCE:
            return
        # Behind a wall the matrix of its force makes corrections small, whatever is left over: one
        # ratio of two does not show it.
        known = not lawful or (iteration > 2 and (rate < 0.5 or size < SMALL * TOLERANCE))
        settled = iteration > 1 and known and size * rate / max(1.0 - rate, 0.1) < TOLERANCE
        if size == 0.0 or settled:
            # rows that no correction closes contradict each other
            inflate(model, workspace.step, 0, workspace.real.x)
            if not largest_left(model, work, work.J, workspace.real.x) > opening:
                counts[codes.TROUBLE] = codes.NONE
            return
        size_last = size


@inlined
def _make_matrix(
    model: Model,
    scheme: Scheme,
    workspace: AlphaWorkspace,
    t_new: float,
    h: float,
    refused: float,
) -> None:
    """Freeze and factorise Newton's matrix, times h^2, at the last evaluation."""
    counts, work, stage = workspace.counts, workspace.work, workspace.stage
    frozen, real = workspace.frozen, workspace.real
    freeze(model, work, t_new, stage, frozen)
    limit = scheme.to_a / refused**2 if refused > 0.0 else 0.0
    update_tension(model, workspace, t_new, workspace.stage_multipliers, limit)
    factorise_pencil(model, frozen, real, scheme.to_a, h * scheme.to_v, h * h)
    if model.quantities.feedback.shape[0] > 0:  # its rows are those of the pencil, times h^2
        scale_feedback(frozen.feedback, h * h)
        factorise_feedback(model, frozen, real, scheme.to_v / h)
    counts[codes.FACTORISATIONS] += 1
    counts[codes.JACOBIANS] += 1


@inlined
def _fill_residuals(model: Model, scheme: Scheme, workspace: AlphaWorkspace, h: float) -> None:
    """Fill load and gamma with the residuals of forces, times h^2, and of constraints."""
    work, real, n_c = workspace.work, workspace.real, model.n_constraint
    n_r = workspace.multipliers.shape[0]
    real.gamma[:] = 0.0
    rate, multipliers = workspace.stage_rate, workspace.stage_multipliers
    inertia_residual(model, work, rate, multipliers, work.f, real.load, real.gamma)
    if n_r > n_c:
        element_residual(model, work, multipliers, real.load, real.gamma)
        for k in range(n_c, n_r):
            real.gamma[k] *= h * h * real.softness[k]
    for i in range(real.load.shape[0]):
        for k in range(real.load.shape[1]):
            real.load[i, k] *= h * h
    if scheme.stabilised:
        evaluate_rates(model, work, workspace.stage)
    for k in range(n_c):
        if scheme.stabilised:
            real.gamma[k] = -h / scheme.to_v * work.left[k]
        else:
            real.gamma[k] = -work.rows[k, PHI]


@inlined
def _correct(model: Model, scheme: Scheme, workspace: AlphaWorkspace, h: float) -> None:
    """Correct the end of the step and the multipliers; with ggl, positions by p as well.

    Leaves the correction in `step` (positions) and `change` (velocities).
    """
    work, real, stage = workspace.work, workspace.real, workspace.stage
    n_pos, n_vel, n_c = model.n_pos, model.n_vel, model.n_constraint
    n_r = workspace.multipliers.shape[0]
    _solve_matrix(model, workspace, scheme.to_v / h, real.load)
    flatten(model, real.x, workspace.change, 0)
    for i in range(n_vel):
        d_z = workspace.change[i]
        workspace.step[i] = d_z
        workspace.z[i] += d_z
        stage[n_pos + i] += scheme.to_v / h * d_z
        workspace.stage_rate[n_pos + i] += scheme.to_a / (h * h) * d_z
        workspace.stage_a[i] += d_z / (scheme.beta * h * h)
    for k in range(n_r):
        workspace.stage_multipliers[k] += real.mu[k] / (h * h)
    for k in range(n_c, n_r):
        real.gamma[k] = 0.0
    if scheme.stabilised:
        row_products(model, work.J, real.x, work.left)
        for k in range(n_c):
            real.gamma[k] = -(work.rows[k, PHI] + work.left[k])
        _solve_matrix(model, workspace, scheme.to_v / h, workspace.zero)
        flatten(model, real.x, workspace.both, 0)
        for i in range(n_vel):
            workspace.shift[i] += workspace.both[i]
            workspace.step[i] += workspace.both[i]
    for i in range(n_vel):
        workspace.change[i] *= scheme.to_v / h


@inlined
def _solve_matrix(model: Model, workspace: AlphaWorkspace, s: float, load: Array) -> None:
    """Solve Newton's equations for load and gamma into x and mu; `s` is that of feedback [1/s]."""
    real = workspace.real
    solve(model.layout, model.layout.newton, real.factors, load, real.gamma, real.x, real.mu)
    if model.quantities.feedback.shape[0] > 0:
        fed_back(model, workspace.frozen, real, s, real.x, workspace.zero)


@inlined
def _estimate_error(
    model: Model, options: Options, scheme: Scheme, workspace: AlphaWorkspace, h: float
) -> float:
    """Return the factor of the next step by the error; TROUBLE tells if that is too large."""
    counts, factor = workspace.counts, 1.0
    if counts[codes.TROUBLE] != codes.NONE:
        return factor
    place(model, workspace)
    if not workspace.clock[codes.TAKEN] > 0.0:
        middle_rates(model, workspace, workspace.clock[codes.TIME], h)
    if not options.fixed_step > 0.0:
        error = local_error(model, options, scheme, workspace, h)
        if not error < 1e300:
            counts[codes.TROUBLE] = codes.ILL
        else:
            factor = SAFETY * max(error, 1e-6) ** (-1.0 / 3.0)
            if error > 1.0:
                counts[codes.TROUBLE] = codes.TOO_ROUGH
    if not finite(workspace.stage):
        counts[codes.TROUBLE] = codes.ILL
    return factor


@inlined
def _estimate_work(
    model: Model,
    options: Options,
    workspace: AlphaWorkspace,
    t_new: float,
    h: float,
    factor: float,
) -> tuple[float, float]:
    """Return the power at the end of the step [W], and the factor of the next by its work too."""
    counts = workspace.counts
    if counts[codes.TROUBLE] != codes.NONE:
        return 0.0, factor
    power = _power(model, workspace, t_new)
    if not options.fixed_step > 0.0:
        last = workspace.y.shape[0] - 1
        error = abs(bent_work(workspace, h, power)) * workspace.weight[last]
        error *= 4.0 * options.rtol ** (1.0 / 3.0)  # the tolerance of a run is this, to the cube
        factor = min(factor, SAFETY * max(error, 1e-6) ** (-1.0 / 3.0))
        if error > 1.0:
            counts[codes.TROUBLE] = codes.TOO_ROUGH
    return power, factor


@inlined
def _power(model: Model, workspace: AlphaWorkspace, t_new: float) -> float:
    """Return the power of drives and forces at the end of the step [W].

    The step's own multipliers lag behind by h^2: where drives do work, those of the end count.
    """
    work, n_c, driven = workspace.work, model.n_constraint, False
    for k in range(n_c):
        driven = driven or work.rows[k, PHI_T] != 0.0
    if not driven:
        return float(work.power[0])
    evaluate(model, work, t_new, workspace.stage)
    accelerate(model, work, t_new, workspace.stage, False)
    workspace.counts[codes.EVALUATIONS] += 1
    return driving_power(model, work)


@inlined
def _fill_rows(
    model: Model,
    scheme: Scheme,
    workspace: AlphaWorkspace,
    t: float,
    h: float,
    times: Array,
    rows: Array,
    filled: int,
) -> int:
    """Fill rows of times within the step of h from t; return how many rows are filled."""
    t_new = workspace.clock[codes.TIME]
    while filled < times.shape[0] and times[filled] <= t_new:
        row = rows[filled]
        interpolate(workspace, h, (times[filled] - t) / h, row)
        if times[filled] == t_new:
            for i in range(row.shape[0]):
                row[i] = workspace.y[i]
        elif model.n_constraint > 0:  # the cubic leaves them as h^4, with index3 as h^3
            close(model, workspace, scheme.to_a**0.5 / h, times[filled], row, workspace.apart)
        filled += 1
    return filled
