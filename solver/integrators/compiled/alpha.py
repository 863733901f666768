"""Generalized-alpha on a Lie group: the step loop for mechanisms, compiled whole.

The method and its letters are those of `GeneralizedAlpha` (integrators/generalized_alpha.py);
matrices of Newton's iteration are those of pencil.py, made fresh with the first evaluation of each
step.
"""

import numpy as np

from ...dynamics.elements.block_vectors import flatten, inflate, row_products
from ...dynamics.evaluation.derivative import accelerate
from ...dynamics.evaluation.evaluation import evaluate, evaluate_rates, largest_left
from ...dynamics.linear_algebra.elimination import solve
from ...dynamics.model.model import Model
from ...dynamics.model.workspace import PHI, PHI_T
from ...math.arrays import Array
from ...math.compiled import lean
from ..generic.alpha_scheme import (
    HYSTERESIS,
    MAX_FACTOR,
    MAX_ITERATIONS,
    MIN_FACTOR,
    SAFETY,
    TOLERANCE,
    Scheme,
)
from .alpha_stages import (
    AlphaWorkspace,
    accept,
    correction_size,
    interpolate,
    local_error,
    place,
    predict,
)
from .closing import close
from .error_norm import finite, set_weights
from .newton.elements import element_residual
from .newton.feedback import scale_feedback
from .newton.pencil import factorise_feedback, factorise_pencil, fed_back, freeze
from .newton.tension import judge, update_tension
from .residual import inertia_residual
from .step_control import (
    ARRIVED,
    EVALUATIONS,
    FACTORISATIONS,
    GOES_ON,
    ILL,
    JACOBIANS,
    NEWTON,
    NEXT,
    NONE,
    PAUSED,
    TAKEN,
    TIME,
    TOO_ROUGH,
    TOO_SMALL,
    TROUBLE,
    Ends,
    Options,
    at_kink,
    count_step,
    keep_end,
    next_step,
    refuse,
)


@lean
def advance_alpha(
    model: Model,
    options: Options,
    scheme: Scheme,
    workspace: AlphaWorkspace,
    most_steps: int,
    times: Array,
    rows: Array,
    filled: int,
    ends: Ends,
) -> tuple[int, int]:
    """Take steps until t_end or `most_steps` accepted ones; see `advance` (radau.py)."""
    clock, counts, work, stage = workspace.clock, workspace.counts, workspace.work, workspace.stage
    frozen, real, plan = workspace.frozen, workspace.real, model.plan
    n_pos, n_vel, n_c = model.n_pos, model.n_vel, model.n_constraint
    n_r = workspace.multipliers.shape[0]
    fixed, feeds = options.fixed_step > 0.0, model.quantities.feedback.shape[0] > 0
    tightest = np.inf
    for i in range(options.atol.shape[0]):
        tightest = min(tightest, options.atol[i])
    opening = options.rtol + tightest  # of constraints after a correction
    taken, refused = 0, 0.0  # steps; the last that Newton's iteration refused, or 0
    while clock[TIME] < options.t_end:
        if taken == most_steps:
            return PAUSED, filled
        t = clock[TIME]
        h, t_new, too_small = next_step(options, clock)
        if too_small:
            return TOO_SMALL, filled

        if at_kink(options, clock):
            # What runs behind, and what is extrapolated, is of other laws.
            clock[TAKEN] = 0.0
            for i in range(n_vel):
                workspace.a[i], workspace.v_dd[i] = workspace.rate[n_pos + i], 0.0
        predict(model, scheme, workspace, h)
        counts[TROUBLE] = NEWTON
        size_last = 0.0
        for iteration in range(1, MAX_ITERATIONS + 1):
            place(model, workspace)
            for k in range(n_c):
                work.multipliers[k] = workspace.stage_multipliers[k]
            evaluate(model, work, t_new, stage)
            counts[EVALUATIONS] += 1
            if iteration == 1:
                freeze(model, work, t_new, stage, frozen)
                update_tension(
                    model,
                    work,
                    t_new,
                    stage,
                    workspace.stage_multipliers,
                    clock,
                    scheme.to_a / refused**2 if refused > 0.0 else 0.0,
                    frozen.M,
                    frozen.tension,
                )
                refused = 0.0
                to_d = h * scheme.to_v
                factorise_pencil(model, frozen, real, scheme.to_a, to_d, h * h)
                if feeds:  # its rows are those of the pencil, times h^2
                    scale_feedback(frozen.feedback, h * h)
                    factorise_feedback(model, frozen, real, scheme.to_v / h)
                counts[FACTORISATIONS] += 1
                counts[JACOBIANS] += 1
                set_weights(options, workspace.y, stage, workspace.weight)
            # forces and constraints left over
            real.gamma[:] = 0.0
            inertia_residual(
                model,
                work.M,
                work.J,
                workspace.stage_rate,
                workspace.stage_multipliers,
                work.f,
                real.load,
                real.gamma,
            )
            if n_r > n_c:
                element_residual(model, work, workspace.stage_multipliers, real.load, real.gamma)
                for k in range(n_c, n_r):
                    real.gamma[k] *= h * h * real.softness[k]
            for i in range(real.load.shape[0]):
                for k in range(real.load.shape[1]):
                    real.load[i, k] *= h * h
            if scheme.stabilised:
                evaluate_rates(model, work, stage)
            for k in range(n_c):
                if scheme.stabilised:
                    real.gamma[k] = -h / scheme.to_v * work.left[k]
                else:
                    real.gamma[k] = -work.rows[k, PHI]
            solve(plan, plan.newton, real.factors, real.load, real.gamma, real.x, real.mu)
            if feeds:
                fed_back(model, frozen, real, scheme.to_v / h, real.x, workspace.zero)
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
                solve(plan, plan.newton, real.factors, workspace.zero, real.gamma, real.x, real.mu)
                if feeds:
                    fed_back(model, frozen, real, scheme.to_v / h, real.x, workspace.zero)
                flatten(model, real.x, workspace.both, 0)
                for i in range(n_vel):
                    workspace.shift[i] += workspace.both[i]
                    workspace.step[i] += workspace.both[i]
            for i in range(n_vel):
                workspace.change[i] *= scheme.to_v / h
            size = correction_size(model, options, workspace)
            if not size < 1e300:
                if iteration == 1:  # later it is the iteration that runs away
                    counts[TROUBLE] = ILL
                break
            rate = size / size_last if iteration > 1 and size_last > 0.0 else 0.0
            # the second correction may exceed the first: a prediction can be too good for its J
            if iteration > 2 and rate >= 1.0 and size > TOLERANCE:
                break
            if size == 0.0 or (iteration > 1 and size * rate / max(1.0 - rate, 0.1) < TOLERANCE):
                # rows that no correction closes contradict each other
                inflate(model, workspace.step, 0, real.x)
                if not largest_left(model, work, work.J, real.x) > opening:
                    counts[TROUBLE] = NONE
                break
            size_last = size

        factor = 1.0
        if counts[TROUBLE] == NONE:
            place(model, workspace)
            if not fixed:
                error = local_error(model, options, scheme, workspace, h)
                if not error < 1e300:
                    counts[TROUBLE] = ILL
                else:
                    factor = SAFETY * max(error, 1e-6) ** (-1.0 / 3.0)
                    if error > 1.0:
                        counts[TROUBLE] = TOO_ROUGH
            if not finite(stage):
                counts[TROUBLE] = ILL

        if counts[TROUBLE] != NONE:
            judge(clock)
            refused = h if counts[TROUBLE] == NEWTON else 0.0
            rough = counts[TROUBLE] == TOO_ROUGH
            factor = max(MIN_FACTOR, min(MAX_FACTOR, factor)) if rough else 0.25
            code = refuse(options, clock, counts, h, factor)
            if code != GOES_ON:
                return code, filled
            continue

        # power of drives and forces; the step's own multipliers lag behind by h^2
        power, driven = work.power[0], False
        for k in range(n_c):
            driven = driven or work.rows[k, PHI_T] != 0.0
        if driven:
            evaluate(model, work, t_new, stage)
            accelerate(model, work, t_new, stage)
            counts[EVALUATIONS] += 1
            power = work.power[0]
            for k in range(n_c):
                power += work.multipliers[k] * work.rows[k, PHI_T]
        accept(model, workspace, h, power)
        factor = max(MIN_FACTOR, min(MAX_FACTOR, factor))
        clock[NEXT] = h if 1.0 <= factor < HYSTERESIS else h * factor
        count_step(clock, counts, h, t_new)
        judge(clock)
        keep_end(ends, taken, t_new, workspace.y)
        taken += 1
        while filled < times.shape[0] and times[filled] <= t_new:
            interpolate(workspace, h, (times[filled] - t) / h, rows[filled])
            if times[filled] == t_new:
                for i in range(workspace.y.shape[0]):
                    rows[filled, i] = workspace.y[i]
            elif n_c > 0:  # the cubic leaves the constraints as h^4, with index3 as h^3
                s = scheme.to_a**0.5 / h
                close(model, work, frozen, real, s, times[filled], rows[filled], workspace.apart)
            filled += 1
    return ARRIVED, filled
