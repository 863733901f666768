"""Radau IIA of order 5: the step loop for mechanisms with modes stiffer than the motion.

Stage equations Z = h A f(y + Z) in the form of residuals (residual.py), by Newton's iteration
with matrices of the second stage (pencil.py). Hairer and Wanner, Solving Ordinary Differential
Equations II, section IV.8, is the source of the transformation, the error estimate, and the
control of steps.
"""

from ...dynamics.model.model import Model
from ...math.arrays import Array
from ...math.compiled import lean
from .closing import close
from .cutoff import energy, filter_error, start_filter
from .dependent_rows import factorise_stages, reduce_multipliers, softened, yield_rows
from .newton.pencil import freeze, solve_pencil
from .newton.tension import judge, update_tension
from .radau_workspace import MU, NU, C, RadauWorkspace
from .residual import residual
from .stages import (
    accept,
    complete,
    correct,
    embedded_error,
    error_residual,
    finite,
    interpolate,
    largest_component,
    norm,
    place,
    predict,
    transform_residuals,
)
from .step_control import (
    ARRIVED,
    CUTOFF,
    ERROR_LAST,
    EVALUATIONS,
    FACTORISATIONS,
    GOES_ON,
    GROWTH,
    ILL,
    JACOBIANS,
    LIMIT,
    NEWTON,
    NEXT,
    NONE,
    OFF,
    PAUSED,
    RATE,
    ROUGH,
    TAKEN,
    TIME,
    TOO_ROUGH,
    TOO_SMALL,
    TROUBLE,
    Ends,
    Options,
    count_step,
    keep_end,
    next_step,
    refuse,
)

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
    """Take steps until t_end or `most_steps` accepted ones; return a code and rows filled.

    One function from the step down to its parts: what is called from deeper inside is compiled
    again at every level.

    Parameters
    ----------
    times, rows : (k,) [s], (k, n); the solution at times within each step goes to its row
    filled : rows that are there already
    ends : of the steps taken, as many as it has room for
    """
    clock, counts, work, stage = workspace.clock, workspace.counts, workspace.work, workspace.stage
    frozen, real, pair, w_c = workspace.frozen, workspace.real, workspace.pair, clock[CUTOFF]
    n = stage.shape[0]
    fixed = options.fixed_step > 0.0
    most = 2 * MAX_ITERATIONS if fixed else MAX_ITERATIONS
    tolerance = max(2e-15 / options.rtol, min(0.01, options.rtol**0.5))
    taken, failures, stored, ringing = 0, 0, 0.0, False
    refused = 0.0  # by Newton's iteration: the last step, or 0
    if w_c > 0.0:
        stored = energy(model, work, clock[TIME], workspace.y, workspace.cutoff.parts)
    while clock[TIME] < options.t_end:
        if taken == most_steps:
            return PAUSED, filled
        t = clock[TIME]
        h, t_new, too_small = next_step(options, clock)
        if too_small:
            return TOO_SMALL, filled

        # stages
        for i in range(n):
            workspace.weight[i] = 1.0 / (options.atol[i] + options.rtol * abs(workspace.y[i]))
        predict(workspace, h, clock[TAKEN])
        counts[TROUBLE] = NEWTON
        # a rate of convergence known from the last step lets one iteration do
        rate, size_last, iterations = max(clock[RATE], 1e-15) ** 0.8, 0.0, 0
        for iteration in range(1, most + 1):
            for k in range(3):
                place(workspace, k, h)
                workspace.power[k] = residual(
                    model,
                    work,
                    t + C[k] * h,
                    stage,
                    workspace.rate,
                    workspace.multipliers[k],
                    workspace.load[k],
                    workspace.gamma[k],
                    workspace.r[k],
                )
                if iteration == 1 and k == 1:
                    freeze(model, work, t + C[k] * h, stage, frozen)
                    update_tension(
                        model,
                        work,
                        t + C[k] * h,
                        stage,
                        workspace.multipliers[k],
                        clock,
                        (MU / refused) ** 2 if refused > 0.0 else 0.0,
                        frozen.M,
                        frozen.tension,
                    )
                    refused = 0.0
            if iteration == 1:
                counts[FACTORISATIONS] += factorise_stages(model, workspace, h)
                counts[JACOBIANS] += 1
            counts[EVALUATIONS] += 3
            yield_rows(workspace)
            transform_residuals(model, workspace)
            solve_pencil(model, frozen, real, MU / h)
            solve_pencil(model, frozen, pair, NU / h)
            size = correct(options, workspace)
            if not size < 1e300:
                if iteration == 1:  # later it is the iteration that runs away
                    counts[TROUBLE] = ILL
                break
            # rounding converges at no rate
            stale = iteration > 1 and size >= size_last and size < ROUNDING * tolerance
            if stale or size < NEGLIGIBLE * tolerance:
                iterations, counts[TROUBLE] = iteration, NONE
                break
            if iteration > 1:
                rate = size / size_last
                to_go = most - iteration
                # The first correction of a good prediction may be smaller than the second, which
                # answers the change of multipliers: two are not enough to see a divergence.
                judged = not fixed and (iteration > 2 or rate > DIVERGES)
                if judged and (rate >= 1.0 or rate**to_go / (1.0 - rate) * size > tolerance):
                    break
            if rate < 1.0 and rate / (1.0 - rate) * size < tolerance:
                iterations, counts[TROUBLE] = iteration, NONE
                break
            size_last = size
        clock[RATE] = rate if iterations > 0 else 1.0

        # error, with what is stiff divided out
        error = 1e-10
        if counts[TROUBLE] == NONE:
            complete(options, workspace, h)
            if not fixed:
                for again in range(2):
                    embedded_error(workspace, h)
                    if again == 0:
                        error_residual(model, workspace)
                    else:
                        # filtered once more: the first error of a stiff transient is too large
                        for i in range(n):
                            stage[i] = workspace.y[i] + real.delta[i]
                            workspace.rate[i] = -workspace.rate[i]
                        residual(
                            model,
                            work,
                            t,
                            stage,
                            workspace.rate,
                            workspace.multipliers_old[2],
                            real.load,
                            real.gamma,
                            real.r,
                        )
                        counts[EVALUATIONS] += 1
                        for i in range(n):
                            stage[i] = workspace.y[i] + workspace.Z[2, i]
                    solve_pencil(model, frozen, real, MU / h)
                    real.delta[n - 1] = 0.0
                    error = norm(options, real.delta, workspace.weight)
                    ringing = error > 1.0
                    if w_c > 0.0:
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
                if not error < 1e300:
                    counts[TROUBLE] = ILL
                elif error > 1.0:
                    counts[TROUBLE] = TOO_ROUGH
                error = max(error, 1e-10)
        damped = SAFETY * (2 * MAX_ITERATIONS + 1) / (2 * MAX_ITERATIONS + iterations)
        factor = damped * error**-0.25

        closes = counts[TROUBLE] == NONE and options.closes
        if closes and not close(model, work, frozen, real, MU / h, t_new, stage, counts):
            counts[TROUBLE] = OFF
        if counts[TROUBLE] == NONE and not finite(stage):
            counts[TROUBLE] = ILL

        if counts[TROUBLE] != NONE:
            judge(clock)
            if counts[TROUBLE] == NEWTON:
                failures, refused = failures + 1, h
                factor = SHORTER if failures == 1 else MUCH_SHORTER
                clock[LIMIT], clock[GROWTH] = h * factor / CAUTION, 1.0
                workspace.blamed[largest_component(stage, workspace.weight)] += (
                    1  # of the last correction
                )
            elif counts[TROUBLE] == OFF:
                factor = 0.25
            else:
                factor = max(MIN_FACTOR, min(1.0, factor))
                if counts[TROUBLE] == TOO_ROUGH:
                    clock[ROUGH] = h
                    rough = workspace.cutoff.error if w_c > 0.0 else real.delta
                    workspace.blamed[largest_component(rough, workspace.weight)] += 1
            code = refuse(options, clock, counts, h, factor)
            if code != GOES_ON:
                return code, filled
            continue

        if softened(frozen):
            reduce_multipliers(model, workspace)
        accept(workspace, h)
        if w_c > 0.0:
            stored -= energy(model, work, t_new, workspace.y, workspace.cutoff.parts)
            if ringing:
                lost = stored + workspace.y[n - 1] - workspace.y_old[n - 1]
                workspace.damped[0] += lost
                workspace.Q[0, n - 1] -= lost
                workspace.y[n - 1] -= lost
            parts = workspace.cutoff.parts
            stored = parts[0] + parts[1] + parts[2]
        if clock[TAKEN] > 0.0:  # Gustafsson: errors that grow ask for more care
            factor *= min(1.0, h / clock[TAKEN] * (clock[ERROR_LAST] / error) ** 0.25)
        limit = CAUTION * min(clock[LIMIT], clock[ROUGH])
        clock[NEXT] = min(h * max(MIN_FACTOR, min(MAX_FACTOR, factor)), limit)
        clock[LIMIT] *= clock[GROWTH]
        clock[GROWTH] = min(FASTEST, clock[GROWTH] + FASTER)
        clock[ROUGH] *= RELAX_ROUGH if error > OVER else RELAX_OVER
        clock[ERROR_LAST] = error
        count_step(clock, counts, h, t_new)
        judge(clock)
        keep_end(ends, taken, t_new, workspace.y)
        taken, failures = taken + 1, 0
        while filled < times.shape[0] and times[filled] <= t_new:
            row = rows[filled]
            interpolate(workspace, (times[filled] - t) / h, row)
            if times[filled] == t_new:
                for i in range(n):
                    row[i] = workspace.y[i]
            elif options.closes:
                close(model, work, frozen, real, MU / h, times[filled], row, workspace.apart)
            filled += 1
    return ARRIVED, filled
