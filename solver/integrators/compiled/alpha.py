"""Generalized-alpha on a Lie group: the step loop for mechanisms, compiled whole.

The method and its letters are those of `GeneralizedAlpha` (integrators/stepping.py); matrices of
Newton's iteration are those of pencil.py, made fresh with the first evaluation of each step.
"""

import numpy as np

from ...dynamics.coordinates import move, rates_into
from ...dynamics.elimination import solve
from ...dynamics.model import Model
from ...dynamics.system import (
    accelerate,
    evaluate,
    evaluate_rates,
    flatten,
    inflate,
    largest_left,
    row_products,
)
from ...dynamics.workspace import PHI, PHI_T
from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ..generic.alpha_scheme import (
    HYSTERESIS,
    MAX_FACTOR,
    MAX_ITERATIONS,
    MIN_FACTOR,
    SAFETY,
    TOLERANCE,
    Scheme,
)
from .alpha_workspace import POWER, POWER_LAST, AlphaWorkspace
from .closing import close
from .elements import element_residual
from .pencil import factorise_pencil, freeze
from .residual import inertia_residual
from .stages import finite, norm
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
    fixed = options.fixed_step > 0.0
    tightest = np.inf
    for i in range(options.atol.shape[0]):
        tightest = min(tightest, options.atol[i])
    opening = options.rtol + tightest  # of constraints after a correction
    taken = 0
    while clock[TIME] < options.t_end:
        if taken == most_steps:
            return PAUSED, filled
        t = clock[TIME]
        h, t_new, too_small = next_step(options, clock)
        if too_small:
            return TOO_SMALL, filled

        _predict(model, scheme, workspace, h)
        counts[TROUBLE] = NEWTON
        size_last = 0.0
        for iteration in range(1, MAX_ITERATIONS + 1):
            _place(model, workspace)
            for k in range(n_c):
                work.multipliers[k] = workspace.stage_multipliers[k]
            evaluate(model, work, t_new, stage)
            counts[EVALUATIONS] += 1
            if iteration == 1:
                freeze(model, work, t_new, stage, frozen)
                to_d = h * scheme.to_v
                factorise_pencil(model, frozen, real, scheme.to_a, to_d, h * h)
                counts[FACTORISATIONS] += 1
                counts[JACOBIANS] += 1
                for i in range(stage.shape[0]):
                    larger = max(abs(workspace.y[i]), abs(stage[i]))
                    workspace.weight[i] = 1.0 / (options.atol[i] + options.rtol * larger)
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
                flatten(model, real.x, workspace.both, 0)
                for i in range(n_vel):
                    workspace.shift[i] += workspace.both[i]
                    workspace.step[i] += workspace.both[i]
            for i in range(n_vel):
                workspace.change[i] *= scheme.to_v / h
            size = _size(model, options, workspace)
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
            _place(model, workspace)
            if not fixed:
                error = _error(model, options, scheme, workspace, h)
                if not error < 1e300:
                    counts[TROUBLE] = ILL
                else:
                    factor = SAFETY * max(error, 1e-6) ** (-1.0 / 3.0)
                    if error > 1.0:
                        counts[TROUBLE] = TOO_ROUGH
            if not finite(stage):
                counts[TROUBLE] = ILL

        if counts[TROUBLE] != NONE:
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
        _accept(model, workspace, h, power)
        factor = max(MIN_FACTOR, min(MAX_FACTOR, factor))
        clock[NEXT] = h if 1.0 <= factor < HYSTERESIS else h * factor
        count_step(clock, counts, h, t_new)
        keep_end(ends, taken, t_new, workspace.y)
        taken += 1
        while filled < times.shape[0] and times[filled] <= t_new:
            _interpolate(workspace, h, (times[filled] - t) / h, rows[filled])
            if times[filled] == t_new:
                for i in range(workspace.y.shape[0]):
                    rows[filled, i] = workspace.y[i]
            elif n_c > 0:  # the cubic leaves the constraints as h^4, with index3 as h^3
                s = scheme.to_a**0.5 / h
                close(model, work, frozen, real, s, times[filled], rows[filled], workspace.apart)
            filled += 1
    return ARRIVED, filled


@inlined
def _predict(model: Model, scheme: Scheme, workspace: AlphaWorkspace, h: float) -> None:
    """Begin Newton's iteration: accelerations go on as over the last step."""
    n_pos, last = model.n_pos, workspace.clock[TAKEN]
    alpha_m, alpha_f, gamma, beta = scheme.alpha_m, scheme.alpha_f, scheme.gamma, scheme.beta
    for i in range(model.n_vel):
        v, v_d = workspace.y[n_pos + i], workspace.rate[n_pos + i]
        a_0 = workspace.a[i]
        if last > 0.0:  # its lag grows and shrinks with the step
            a_0 = v_d + (a_0 - v_d) * (h / last)
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
def _place(model: Model, workspace: AlphaWorkspace) -> None:
    """Fill the positions of workspace.stage: the last state's, moved by z + shift."""
    for i in range(model.n_vel):
        workspace.step[i] = workspace.z[i] + workspace.shift[i]
    for i in range(model.n_pos):
        workspace.stage[i] = workspace.y[i]
    move(model, workspace.stage, workspace.step)


@inlined
def _size(model: Model, options: Options, workspace: AlphaWorkspace) -> float:
    """Size of `step` of positions and `change` of velocities in units of tolerance."""
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


@inlined
def _error(
    model: Model, options: Options, scheme: Scheme, workspace: AlphaWorkspace, h: float
) -> float:
    """Local error of positions and velocities.

    h^3 (beta + (alpha_m - alpha_f) / 2 - 1/6) vddot and, from the second step on,
    h^3 (1/12 - (alpha_m - alpha_f)^2 / 2) vdddot; both pass the step's own matrix, which
    takes out what is stiff or against the constraints and damped there anyway. What the
    constraints prescribe is exact at the end of the step, but a cubic within it, off by
    h^4 vdddot / 384.
    """
    n_pos, n_vel, last, real = model.n_pos, model.n_vel, workspace.clock[TAKEN], workspace.real
    frozen, factors, plan = workspace.frozen, workspace.real.factors, model.plan
    both = workspace.both
    for i in range(n_vel):
        v_dd = (workspace.stage_rate[n_pos + i] - workspace.rate[n_pos + i]) / h
        both[n_pos + i] = -scheme.to_a * h**3 * scheme.error_q * v_dd
        workspace.change[i] = 2.0 * (v_dd - workspace.v_dd[i]) / (h + last)
    real.gamma[:] = 0.0
    inertia_residual(
        model, frozen.M, frozen.J, both, workspace.no_load, workspace.zero, real.load, real.gamma
    )
    real.gamma[:] = 0.0
    solve(plan, plan.newton, factors, real.load, real.gamma, real.x, real.mu)
    flatten(model, real.x, workspace.step, 0)
    if last > 0.0:
        for i in range(n_vel):
            both[n_pos + i] = -scheme.to_a * h**3 * scheme.error_v * workspace.change[i]
        inertia_residual(
            model,
            frozen.M,
            frozen.J,
            both,
            workspace.no_load,
            workspace.zero,
            real.load,
            real.gamma,
        )
        # what the constraints prescribe is exact at the end, but a cubic within the step
        inflate(model, workspace.change, 0, real.x)
        real.gamma[:] = 0.0
        solve(plan, plan.newton, factors, real.load, real.gamma, real.rho, real.mu)
        row_products(model, frozen.J, real.x, real.gamma)
        flatten(model, real.rho, workspace.change, 0)
        solve(plan, plan.newton, factors, workspace.zero, real.gamma, real.x, real.mu)
        for i in range(model.n_body):
            j = model.vel_start[i]
            for k in range(plan.size[i]):
                prescribed = abs(real.x[i, k]) * h**4 / 384.0
                workspace.step[j + k] = abs(workspace.step[j + k]) + prescribed
    else:
        workspace.change[:] = 0.0
    for i in range(both.shape[0]):
        larger = max(abs(workspace.y[i]), abs(workspace.stage[i]))
        workspace.weight[i] = 1.0 / (options.atol[i] + options.rtol * larger)
    return _size(model, options, workspace)


@inlined
def _accept(model: Model, workspace: AlphaWorkspace, h: float, power: float) -> None:
    """Make the end of the step the state."""
    clock, n_pos, last = workspace.clock, model.n_pos, workspace.clock[TAKEN]
    n = workspace.y.shape[0] - 1
    work = 0.5 * h * (clock[POWER] + power)
    if last > 0.0:  # a parabola through this step's and the last one's powers
        slope = (power - clock[POWER]) / h - (clock[POWER] - clock[POWER_LAST]) / last
        work -= h**3 / 6.0 * slope / (h + last)
    clock[POWER_LAST], clock[POWER] = clock[POWER], power
    workspace.stage[n] = workspace.y[n] + work
    rates_into(model, workspace.stage, workspace.stage_rate)
    workspace.stage_rate[n] = power
    for i in range(model.n_vel):
        j = n_pos + i
        workspace.v_dd[i] = (workspace.stage_rate[j] - workspace.rate[j]) / h
        workspace.a[i] = workspace.stage_a[i]
    for i in range(n + 1):
        workspace.y_old[i], workspace.y[i] = workspace.y[i], workspace.stage[i]
        workspace.rate_old[i], workspace.rate[i] = workspace.rate[i], workspace.stage_rate[i]
    for k in range(workspace.multipliers.shape[0]):
        workspace.multipliers[k] = workspace.stage_multipliers[k]


@inlined
def _interpolate(workspace: AlphaWorkspace, h: float, x: float, out: Array) -> None:
    """Fill out (n,) with the cubic through both ends of the last step at its part x, 0 to 1."""
    rise, bent = x * x * (3.0 - 2.0 * x), x * (1.0 - x) * h
    for i in range(out.shape[0]):
        out[i] = (1.0 - rise) * workspace.y_old[i] + rise * workspace.y[i]
        out[i] += bent * ((1.0 - x) * workspace.rate_old[i] - x * workspace.rate[i])
