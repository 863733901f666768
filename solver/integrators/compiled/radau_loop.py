"""Radau IIA of order 5: the step loop for mechanisms with modes stiffer than the motion.

Stage equations Z = h A f(y + Z) in the form of residuals (residual.py), by Newton's iteration
with matrices of the second stage (pencil.py). Hairer and Wanner, Solving Ordinary Differential
Equations II, section IV.8, is the source of the transformation, the error estimate, and the
control of steps.
"""

from ...dynamics.model.model import PHI_T, Model
from ...math.arrays import Array
from ...math.compiled import inlined, lean
from . import step_control as codes
from .closing import close
from .cutoff import energy, filter_error, start_filter
from .pencil import freeze, solve_pencil
from .radau_stages import (
    MU,
    NU,
    C,
    RadauWorkspace,
    accept,
    complete,
    correct,
    embedded_error,
    error_residual,
    factorise_stages,
    interpolate,
    place,
    predict,
    reduce_multipliers,
    restart_radau,
    softened,
    transform_residuals,
    yield_rows,
)
from .residual import residual
from .step_control import (
    Ends,
    Options,
    at_instant,
    count_step,
    finite,
    keep_end,
    largest_component,
    next_step,
    norm,
    refuse,
    set_weights,
)
from .tension import judge, update_tension

MAX_ITERATIONS = 10
DIVERGES = 10.0  # the second correction over the first
# A step that the limit after a refusal allows, over the limit.
CAUTION = 0.8
# After a step whose iteration failed: the next attempt, and those after more failures in a row;
# growth of the limit, which begins with one, from step to step, and the largest.
SHORTER, MUCH_SHORTER = 0.5, 0.2
FASTER, FASTEST = 0.1, 2.0
# Of a step that was too rough: at h w = 1 the error of a vibration swings with its phase, and a
# step that grows after a small one is refused. Errors far below one say that the vibration is over.
RELAX_ROUGH, RELAX_OVER, OVER = 1.02, 1.2, 0.01
SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 8.0
INFINITE, LEAST_ERROR = 1e300, 1e-10  # of sizes in tolerances
# Corrections, over what Newton's iteration may leave: the first, and later ones that do not shrink.
NEGLIGIBLE, ROUNDING = 1e-3, 0.1


@lean
def advance(
    model: Model,
    options: Options,
    workspace: RadauWorkspace,
    most_steps: int,
    times: Array,
    rows: Array,
    filled: int,
    ends: Ends,
) -> tuple[int, int]:
    """Take steps until END or `most_steps` accepted ones; return a code and rows filled.

    Parameters
    ----------
    times, rows : (k,) [s], (k, n); the solution at times within each step goes to its row
    filled : rows that are there already
    ends : of the steps taken, as many as it has room for
    """
    clock, counts = workspace.clock, workspace.counts
    fixed, filtered = options.fixed_step > 0.0, clock[codes.CUTOFF] > 0.0
    taken, failures = 0, 0  # steps; attempts in a row that Newton's iteration refused,
    refused = 0.0  # and the step of the last attempt if it did, else 0
    stored, ringing = 0.0, False  # energy; whether an error above the cutoff was left out
    if filtered:
        stored = energy(
            model, workspace.work, clock[codes.TIME], workspace.y, workspace.cutoff.parts
        )
    while clock[codes.TIME] < clock[codes.END]:
        if taken == most_steps:
            return codes.PAUSED, filled
        t = clock[codes.TIME]
        h, t_new, too_small = next_step(options, clock)
        if too_small:
            return codes.TOO_SMALL, filled

        set_weights(options, workspace.y, workspace.y, workspace.weight)
        predict(model, workspace, h)
        iterations = _solve_stages(model, options, workspace, t, h, refused)
        refused, error = 0.0, LEAST_ERROR
        if counts[codes.TROUBLE] == codes.NONE:
            complete(options, workspace, h)
            if not fixed:
                error, ringing = _estimate_error(model, options, workspace, t, h)
        if counts[codes.TROUBLE] == codes.NONE:
            _close_end(model, options, workspace, h, t_new)
        factor = _step_factor(error, iterations)

        if counts[codes.TROUBLE] != codes.NONE:
            judge(clock)
            if counts[codes.TROUBLE] == codes.NEWTON:
                failures, refused = failures + 1, h
            factor = _shorter(workspace, h, factor, failures)
            code = refuse(options, clock, counts, h, factor)
            if code != codes.GOES_ON:
                return code, filled
            continue

        if softened(workspace.frozen):
            reduce_multipliers(model, workspace)
        accept(workspace, h)
        if filtered:
            stored = _book_damping(model, workspace, t_new, stored, ringing)
        _choose_step(clock, h, factor, error)
        count_step(clock, counts, h, t_new)
        judge(clock)
        filled = _fill_rows(model, options, workspace, t, h, times, rows, filled)
        if at_instant(options, clock):
            restart_radau(model, workspace, t_new, True)
            counts[codes.EVALUATIONS] += 1
        keep_end(ends, taken, t_new, workspace.y)
        if taken < ends.Z.shape[0]:
            for k in range(3):
                for i in range(ends.Z.shape[2]):
                    ends.Z[taken, k, i] = workspace.Z[k, i]
                for i in range(ends.multipliers.shape[2]):
                    ends.multipliers[taken, k, i] = workspace.multipliers[k, i]
        taken, failures = taken + 1, 0
    return codes.ARRIVED, filled


@inlined
def _solve_stages(
    model: Model,
    options: Options,
    workspace: RadauWorkspace,
    t: float,
    h: float,
    refused: float,
) -> int:
    """Solve the stage equations by Newton's iteration; return the number of iterations.

    Leaves the rate of convergence in `clock`, and in TROUBLE whether it has failed.

    Parameters
    ----------
    t, h : time and step [s]
    refused : the last attempt, if Newton's iteration refused it [s]; else 0
    """
    clock, counts, frozen = workspace.clock, workspace.counts, workspace.frozen
    fixed = options.fixed_step > 0.0
    most = 2 * MAX_ITERATIONS if fixed else MAX_ITERATIONS
    tolerance = max(2e-15 / options.rtol, min(0.01, options.rtol**0.5))
    # a rate of convergence known from the last step lets one iteration do
    rate, size_last, work_last = max(clock[codes.RATE], 1e-15) ** 0.8, 0.0, INFINITE
    # Without a prediction the first correction is nearly all of the motion. The second one over it
    # then says nothing of a steep law, such as friction on a body that begins to slide. Fixed steps
    # have no error control.
    unpredicted = not fixed and counts[codes.STEPS] == clock[codes.BEGUN]
    counts[codes.TROUBLE], clock[codes.RATE] = codes.NEWTON, 1.0
    for iteration in range(1, most + 1):
        _stage_residuals(model, workspace, t, h, iteration == 1, refused)
        if iteration == 1:
            counts[codes.FACTORISATIONS] += factorise_stages(model, workspace, h)
            counts[codes.JACOBIANS] += 1
        yield_rows(workspace)
        transform_residuals(model, workspace)
        solve_pencil(model, frozen, workspace.real, MU / h)
        solve_pencil(model, frozen, workspace.pair, NU / h)
        size, work = correct(model, options, workspace, h)
        if not size < INFINITE:
            if iteration == 1:  # later it is the iteration that runs away
                counts[codes.TROUBLE] = codes.ILL
            return iteration
        # rounding converges at no rate
        stale = iteration > 1 and size >= size_last and size < ROUNDING * tolerance
        converged = stale or size < NEGLIGIBLE * tolerance
        if not converged and iteration > 1:
            rate = size / size_last
            to_go = most - iteration
            # The first correction of a good prediction may be smaller than the second, which
            # answers the change of multipliers: two are not enough to see a divergence.
            judged = (
                not fixed
                and counts[codes.TROUBLE] != codes.NONE
                and (iteration > 2 or rate > DIVERGES)
            )
            if judged and (rate >= 1.0 or rate**to_go / (1.0 - rate) * size > tolerance):
                return iteration
        known = not unpredicted or iteration != 2 or size < tolerance
        if converged or (known and rate < 1.0 and rate / (1.0 - rate) * size < tolerance):
            counts[codes.TROUBLE], clock[codes.RATE] = codes.NONE, rate
        # For a drive at constant speed the error of the multipliers has the same sign in all steps:
        # errors of its work add up. Closing the joints corrects the motion, not the work.
        summed = work * workspace.weight[workspace.y.shape[0] - 1] * (1.0 + counts[codes.STEPS])
        if counts[codes.TROUBLE] == codes.NONE and not 1.0 < summed < work_last:
            return iteration
        size_last, work_last = size, summed
    return most


@inlined
def _stage_residuals(
    model: Model, workspace: RadauWorkspace, t: float, h: float, first: bool, refused: float
) -> None:
    """Fill the residuals of the three stages; in the first iteration freeze the matrices."""
    work, stage, frozen = workspace.work, workspace.stage, workspace.frozen
    for k in range(3):
        place(workspace, k, h)
        load, gamma, r = workspace.load[k], workspace.gamma[k], workspace.r[k]
        multipliers = workspace.multipliers[k]
        workspace.power[k] = residual(model, workspace, t + C[k] * h, multipliers, load, gamma, r)
        for i in range(model.n_constraint):
            workspace.driven[k, i] = work.rows[i, PHI_T]
        if first and k == 1:
            freeze(model, work, t + C[k] * h, stage, frozen)
            limit = (MU / refused) ** 2 if refused > 0.0 else 0.0
            update_tension(model, workspace, t + C[k] * h, multipliers, limit)
    workspace.counts[codes.EVALUATIONS] += 3


@inlined
def _estimate_error(
    model: Model, options: Options, workspace: RadauWorkspace, t: float, h: float
) -> tuple[float, bool]:
    """Return the error of a step in tolerances, and whether a vibration above the cutoff rings.

    Hairer and Wanner, IV.8: what is stiff is divided out of the embedded formula's difference; an
    error above one is filtered once more, because the first one of a stiff transient is too large.
    """
    counts, frozen, real = workspace.counts, workspace.frozen, workspace.real
    n, w_c, error, ringing = workspace.stage.shape[0], workspace.clock[codes.CUTOFF], 0.0, False
    for again in range(2):
        embedded_error(workspace, h)
        if again == 0:
            error_residual(model, workspace)
        else:
            _filtered_residual(model, workspace, t)
        solve_pencil(model, frozen, real, MU / h)
        real.delta[n - 1] = 0.0
        error = norm(options, real.delta, workspace.weight)
        ringing = error > 1.0
        if w_c != 0.0:
            if again == 0:
                start_filter(model, frozen, workspace.cutoff, w_c)
            filter_error(model, workspace.cutoff, w_c, real.delta)
            error = norm(options, workspace.cutoff.error, workspace.weight)
        if not error > 1.0:
            if again == 0 and frozen.stiffness.shape[0] == 0 and w_c == 0.0:
                # The work is a quadrature. That of what is stiff is not resolved.
                real.delta[n - 1] = real.r[n - 1] * h / MU
                error = norm(options, real.delta, workspace.weight)
            break
    if not error < INFINITE:
        counts[codes.TROUBLE] = codes.ILL
    elif error > 1.0:
        counts[codes.TROUBLE] = codes.TOO_ROUGH
    return max(error, LEAST_ERROR), ringing


@inlined
def _filtered_residual(model: Model, workspace: RadauWorkspace, t: float) -> None:
    """Hand the embedded formula's difference at the state corrected by the error to the pencil."""
    stage, real = workspace.stage, workspace.real
    for i in range(stage.shape[0]):
        stage[i] = workspace.y[i] + real.delta[i]
        workspace.rate[i] = -workspace.rate[i]
    residual(model, workspace, t, workspace.multipliers_old[2], real.load, real.gamma, real.r)
    workspace.counts[codes.EVALUATIONS] += 1
    for i in range(stage.shape[0]):
        stage[i] = workspace.y[i] + workspace.Z[2, i]


@inlined
def _close_end(
    model: Model, options: Options, workspace: RadauWorkspace, h: float, t_new: float
) -> None:
    """Bring the end of the step onto the constraints; set TROUBLE if that fails."""
    counts, stage, closed = workspace.counts, workspace.stage, True
    if options.closes:
        closed = close(model, workspace, MU / h, t_new, stage, counts)
    if not closed:
        counts[codes.TROUBLE] = codes.OFF
    elif not finite(stage):
        counts[codes.TROUBLE] = codes.ILL


@inlined
def _step_factor(error: float, iterations: int) -> float:
    """Return the next step over this one, by its error and the iterations that it took."""
    damped = SAFETY * (2 * MAX_ITERATIONS + 1) / (2 * MAX_ITERATIONS + iterations)
    return damped * error**-0.25


@inlined
def _shorter(workspace: RadauWorkspace, h: float, factor: float, failures: int) -> float:
    """Return the next attempt over the one of h that was refused; note its limits and component.

    Parameters
    ----------
    factor : by the error
    failures : attempts in a row that Newton's iteration refused
    """
    clock, trouble, blamed = workspace.clock, workspace.counts[codes.TROUBLE], workspace.blamed
    if trouble == codes.NEWTON:
        factor = SHORTER if failures == 1 else MUCH_SHORTER
        clock[codes.LIMIT], clock[codes.GROWTH] = h * factor / CAUTION, 1.0
        # `stage` is the last correction
        blamed[largest_component(workspace.stage, workspace.weight)] += 1
    elif trouble == codes.OFF:
        factor = 0.25
    else:
        factor = max(MIN_FACTOR, min(1.0, factor))
        if trouble == codes.TOO_ROUGH:
            clock[codes.ROUGH] = h
            rough = workspace.cutoff.error if clock[codes.CUTOFF] != 0.0 else workspace.real.delta
            blamed[largest_component(rough, workspace.weight)] += 1
    return factor


@inlined
def _book_damping(
    model: Model, workspace: RadauWorkspace, t_new: float, stored: float, ringing: bool
) -> float:
    """Book the energy that vibrations above the cutoff have lost; return the energy stored [J]."""
    parts, last = workspace.cutoff.parts, workspace.y.shape[0] - 1
    stored -= energy(model, workspace.work, t_new, workspace.y, parts)
    if ringing:
        lost = stored + workspace.y[last] - workspace.y_old[last]
        workspace.damped[0] += lost
        workspace.Q[0, last] -= lost
        workspace.y[last] -= lost
    return parts[0] + parts[1] + parts[2]


@inlined
def _choose_step(clock: Array, h: float, factor: float, error: float) -> None:
    """Choose the step after an accepted one of h, within the limits that refusals have left."""
    if clock[codes.TAKEN] > 0.0:  # Gustafsson: errors that grow ask for more care
        factor *= min(1.0, h / clock[codes.TAKEN] * (clock[codes.ERROR_LAST] / error) ** 0.25)
    limit = CAUTION * min(clock[codes.LIMIT], clock[codes.ROUGH])
    clock[codes.NEXT] = min(h * max(MIN_FACTOR, min(MAX_FACTOR, factor)), limit)
    clock[codes.LIMIT] *= clock[codes.GROWTH]
    clock[codes.GROWTH] = min(FASTEST, clock[codes.GROWTH] + FASTER)
    clock[codes.ROUGH] *= RELAX_ROUGH if error > OVER else RELAX_OVER
    clock[codes.ERROR_LAST] = error


@inlined
def _fill_rows(
    model: Model,
    options: Options,
    workspace: RadauWorkspace,
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
        interpolate(workspace, (times[filled] - t) / h, row)
        if times[filled] == t_new:
            for i in range(row.shape[0]):
                row[i] = workspace.y[i]
        elif options.closes:
            close(model, workspace, MU / h, times[filled], row, workspace.apart)
        filled += 1
    return filled
