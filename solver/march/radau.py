"""Radau IIA of order 5: the step loop for mechanisms with modes stiffer than the motion."""

from typing import NamedTuple

import numpy as np

from ..compiled import inlined, jit
from ..model import Model
from ..package.schema import Array, IntArray
from ..projection import project
from ..system import derivative_into
from ..workspace import Work, new_work
from .closing import close
from .pencil import (
    Frozen,
    Pencil,
    factorise_pencil,
    freeze,
    new_frozen,
    new_pencil,
    solve_pencil,
)
from .residual import leave, rest
from .tableau import A_INVERSE, ERROR, MU, NU, POWERS, T_INVERSE, A, C, T

MAX_ITERATIONS = 10
SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 8.0
KEEP = 1.2  # a change of step below this is not worth new factors

# What a call comes back with.
ARRIVED, PAUSED, TOO_SMALL, NOT_FINITE, REFUSED = 0, 1, 2, 3, 4
# Entries of `clock`.
TIME, NEXT, TAKEN, ERROR_LAST, RATE = 0, 1, 2, 3, 4
# Entries of `counts`.
STEPS, REJECTED, EVALUATIONS, JACOBIANS, FACTORISATIONS, BAD, TROUBLE = 0, 1, 2, 3, 4, 5, 6
# Entries of TROUBLE: why the last attempt was refused.
NONE, NEWTON, TOO_ROUGH, ILL, OFF = 0, 1, 2, 3, 4


class Options(NamedTuple):
    """What does not change during a run."""

    t_end: float
    rtol: float
    atol: Array  # (n,)
    block_starts: IntArray  # (b + 1,)
    max_step: float
    min_step: float
    fixed_step: float  # 0: error control
    projects: bool


class Course(NamedTuple):
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
    multipliers: Array  # (3, n_c) at the stages
    multipliers_old: Array  # (3, n_c) at those of the last step
    power: Array  # (3,) at the stages [W]
    load: Array  # (3, nb, n) what the stages leave: forces,
    gamma: Array  # (3, n_c) constraints
    r: Array  # (3, n) and kinematics
    stage: Array  # (n,)
    rate: Array  # (n,) at a stage
    weight: Array  # (n,)
    clock: Array  # (5,)
    counts: IntArray  # (7,)


@jit
def new_course(model: Model, t: float, y: Array, first_step: float) -> Course:
    """Return memory for a run from state y (n,) at time t [s]."""
    n, n_c, nb, widest = y.shape[0], model.n_constraint, model.n_body, model.plan.widest
    course = Course(
        new_work(model),
        new_frozen(model),
        new_pencil(model, 1.0),
        new_pencil(model, 1.0 + 0.0j),
        y.copy(),
        np.zeros(n),
        y.copy(),
        np.zeros((3, n)),
        np.zeros((3, n)),
        np.zeros((3, n_c)),
        np.zeros((3, n_c)),
        np.zeros(3),
        np.zeros((3, nb, widest)),
        np.zeros((3, n_c)),
        np.zeros((3, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(5),
        np.zeros(7, dtype=np.int64),
    )
    course.clock[TIME], course.clock[NEXT], course.clock[ERROR_LAST] = t, first_step, 1.0
    course.clock[RATE] = 1.0
    derivative_into(model, course.work, t, y, course.f)
    for k in range(3):
        course.multipliers_old[k] = course.work.multipliers
    course.counts[EVALUATIONS] = 1
    return course


@jit
def advance(
    model: Model,
    options: Options,
    course: Course,
    most_steps: int,
    times: Array,
    rows: Array,
    filled: int,
) -> tuple[int, int]:
    """Take steps until t_end or `most_steps` accepted ones; return a code and rows filled.

    Parameters
    ----------
    times, rows : (k,) [s], (k, n); the solution at times within each step goes to its row
    filled : rows that are there already
    """
    clock, counts = course.clock, course.counts
    taken = 0
    while clock[TIME] < options.t_end:
        if taken == most_steps:
            return PAUSED, filled
        t = clock[TIME]
        h, t_new = _limited(options, t, clock[NEXT])
        if h < max(options.min_step, 2e-15 * abs(t), 1e-300) and t_new < options.t_end:
            return TOO_SMALL, filled
        if not _attempt(model, options, course, t, h, t_new):
            counts[REJECTED] += 1
            if options.fixed_step > 0.0:
                return REFUSED, filled
            if counts[BAD] > 25:
                return NOT_FINITE, filled
            continue
        taken += 1
        counts[STEPS] += 1
        counts[BAD] = 0
        clock[TIME] = t_new
        while filled < times.shape[0] and times[filled] <= t_new:
            interpolate(course, t, h, times[filled], rows[filled])
            if times[filled] == t_new:
                rows[filled] = course.y
            elif options.projects:
                project(model, course.work, times[filled], rows[filled])
            filled += 1
    return ARRIVED, filled


@inlined
def _limited(options: Options, t: float, h: float) -> tuple[float, float]:
    """Step and its end: within the largest step, on t_end exactly, no sliver before it."""
    left, stretch = options.t_end - t, 1.01
    if options.fixed_step > 0.0:
        h, stretch = options.fixed_step, 1.0 + 1e-6
    h = min(h, options.max_step)
    if h * stretch >= left:
        return left, options.t_end
    return h, t + h


@jit
def interpolate(course: Course, t_old: float, h: float, t: float, out: Array) -> None:
    """Fill out (n,) with the polynomial of the last step at t."""
    x = (t - t_old) / h
    for i in range(out.shape[0]):
        Q = course.Q
        out[i] = course.y_old[i] + x * (Q[0, i] + x * (Q[1, i] + x * Q[2, i]))


@jit
def _attempt(
    model: Model, options: Options, course: Course, t: float, h: float, t_new: float
) -> bool:
    """Try one step of h from t; tell whether it was accepted, and leave the next size."""
    clock, counts, n = course.clock, course.counts, course.y.shape[0]
    y, Z, stage, weight = course.y, course.Z, course.stage, course.weight
    for i in range(n):
        weight[i] = 1.0 / (options.atol[i] + options.rtol * abs(y[i]))
    _predict(course, h)
    iterations = _newton(model, options, course, t, h)
    if iterations == 0:
        clock[NEXT] = (0.1 if counts[TROUBLE] == ILL else 0.5) * h
        return False
    last = n - 1  # work of drives and dampers: a sum, no unknown
    for k in range(3):
        power = course.power
        Z[k, last] = h * (A[k, 0] * power[0] + A[k, 1] * power[1] + A[k, 2] * power[2])
    for i in range(n):
        stage[i] = y[i] + Z[2, i]
        weight[i] = 1.0 / (options.atol[i] + options.rtol * max(abs(y[i]), abs(stage[i])))
    error = _error(model, options, course, t, h)
    if not error < 1e300:
        return _ill(course, h)
    error = max(error, 1e-10)
    damped = SAFETY * (2 * MAX_ITERATIONS + 1) / (2 * MAX_ITERATIONS + iterations)
    factor = damped * error**-0.25
    if error > 1.0 and options.fixed_step == 0.0:
        counts[TROUBLE] = TOO_ROUGH
        clock[NEXT] = h * max(MIN_FACTOR, min(1.0, factor))
        return False
    if options.projects:
        count = close(model, course.work, course.frozen, course.real, MU / h, t_new, stage)
        counts[EVALUATIONS] += abs(count)
        if count < 0:
            counts[TROUBLE] = OFF
            clock[NEXT] = 0.25 * h
            return False
    if not _finite(stage):
        return _ill(course, h)
    course.multipliers_old[:] = course.multipliers
    AI, Q = A_INVERSE, course.Q
    for i in range(n):
        course.y_old[i], y[i] = y[i], stage[i]
        z0, z1, z2 = Z[0, i], Z[1, i], Z[2, i]
        course.f[i] = (AI[2, 0] * z0 + AI[2, 1] * z1 + AI[2, 2] * z2) / h
        for k in range(3):
            Q[k, i] = POWERS[k, 0] * z0 + POWERS[k, 1] * z1 + POWERS[k, 2] * z2
    if clock[TAKEN] > 0.0:  # Gustafsson: errors that grow ask for more care
        growing = h / clock[TAKEN] * (clock[ERROR_LAST] / error) ** 0.25
        factor *= min(1.0, growing)
    clock[NEXT] = h * max(MIN_FACTOR, min(MAX_FACTOR, factor))
    clock[TAKEN], clock[ERROR_LAST] = h, error
    counts[TROUBLE] = NONE
    return True


@inlined
def _ill(course: Course, h: float) -> bool:
    """Refuse a step whose numbers are not finite."""
    course.counts[TROUBLE] = ILL
    course.counts[BAD] += 1
    course.clock[NEXT] = 0.1 * h
    return False


@inlined
def _error(model: Model, options: Options, course: Course, t: float, h: float) -> float:
    """Error of the embedded formula of order 3, with what is stiff divided out."""
    counts, real, n = course.counts, course.real, course.y.shape[0]
    for i in range(n):
        course.r[0, i] = course.f[i]
    for again in range(2):
        if again == 1:
            # filtered once more: the first error of a stiff transient is too pessimistic
            for i in range(n):
                course.rate[i] = course.y[i] + real.delta[i]
            derivative_into(model, course.work, t, course.rate, course.r[0])
            counts[EVALUATIONS] += 1
        _tilt(model, course, h)
        solve_pencil(model, course.frozen, real, MU / h)
        real.delta[n - 1] = 0.0
        error = _norm(options, real.delta, course.weight)
        if not error > 1.0 or options.fixed_step > 0.0:
            break
    return error


@inlined
def _tilt(model: Model, course: Course, h: float) -> None:
    """Right-hand side f + ERROR Z / h of the error, with velocities as forces."""
    r, Z, real, frozen = course.r[0], course.Z, course.real, course.frozen
    for i in range(r.shape[0]):
        # rests are what is left of zero: their sign
        r[i] += (ERROR[0] * Z[0, i] + ERROR[1] * Z[1, i] + ERROR[2] * Z[2, i]) / h
        real.r[i] = r[i]
        r[i] = -r[i]
    course.gamma[0, :] = 0.0
    course.load[0, :, :] = 0.0
    real.gamma[:] = 0.0
    rest(model, frozen.M, frozen.J, r, course.gamma[0], course.load[0], real.load, real.gamma)


@inlined
def _predict(course: Course, h: float) -> None:
    """Begin with the polynomials of the last step, continued."""
    Z, Q, last = course.Z, course.Q, course.clock[TAKEN]
    L, L_old = course.multipliers, course.multipliers_old
    for k in range(3):
        x = 1.0 + C[k] * h / last if last > 0.0 else 1.0
        for i in range(course.y.shape[0]):
            whole = Q[0, i] + Q[1, i] + Q[2, i]
            Z[k, i] = x * (Q[0, i] + x * (Q[1, i] + x * Q[2, i])) - whole
        # what extends a parabola through the last stages
        w = 0.0 if last > 0.0 else 1.0
        w0 = w + (1.0 - w) * (x - C[1]) * (x - C[2]) / ((C[0] - C[1]) * (C[0] - C[2]))
        w1 = (1.0 - w) * (x - C[0]) * (x - C[2]) / ((C[1] - C[0]) * (C[1] - C[2]))
        w2 = (1.0 - w) * (x - C[0]) * (x - C[1]) / ((C[2] - C[0]) * (C[2] - C[1]))
        for i in range(L.shape[1]):
            L[k, i] = w0 * L_old[0, i] + w1 * L_old[1, i] + w2 * L_old[2, i]


@inlined
def _newton(model: Model, options: Options, course: Course, t: float, h: float) -> int:
    """Solve for the stages; return the number of iterations, 0 if they failed."""
    counts, clock = course.counts, course.clock
    fixed = options.fixed_step > 0.0
    most = 2 * MAX_ITERATIONS if fixed else MAX_ITERATIONS
    tolerance = max(2e-15 / options.rtol, min(0.01, options.rtol**0.5))
    size_last = 0.0
    # a rate of convergence known from the last step lets one iteration do
    rate = max(clock[RATE], 1e-15) ** 0.8
    for iteration in range(1, most + 1):
        _evaluate_stages(model, course, t, h, iteration == 1)
        if iteration == 1:
            factorise_pencil(model, course.frozen, course.real, MU / h)
            factorise_pencil(model, course.frozen, course.pair, NU / h)
            counts[FACTORISATIONS] += 1
        counts[EVALUATIONS] += 3
        size = _correct(model, options, course, h)
        if not size < 1e300:
            counts[TROUBLE] = ILL
            counts[BAD] += 1
            return 0
        if iteration > 1 and size_last > 0.0:
            rate = size / size_last
            left = most - iteration
            far = rate >= 1.0 or rate**left / (1.0 - rate) * size > tolerance
            if far and not fixed:
                break
        clock[RATE] = rate
        if size == 0.0 or (rate < 1.0 and rate / (1.0 - rate) * size < tolerance):
            return iteration
        size_last = size
    counts[TROUBLE] = NEWTON
    clock[RATE] = 1.0
    return 0


@inlined
def _evaluate_stages(model: Model, course: Course, t: float, h: float, first: bool) -> None:
    """Fill what the three stages leave; the matrices of the second one are kept, if `first`."""
    Z, AI, rate, stage = course.Z, A_INVERSE, course.rate, course.stage
    for k in range(3):
        for i in range(stage.shape[0]):
            stage[i] = course.y[i] + Z[k, i]
            rate[i] = (AI[k, 0] * Z[0, i] + AI[k, 1] * Z[1, i] + AI[k, 2] * Z[2, i]) / h
        course.power[k] = leave(
            model,
            course.work,
            t + C[k] * h,
            stage,
            rate,
            course.multipliers[k],
            course.load[k],
            course.gamma[k],
            course.r[k],
        )
        if first and k == 1:
            freeze(model, course.work, stage, course.frozen)


@inlined
def _correct(model: Model, options: Options, course: Course, h: float) -> float:
    """One correction of stages and multipliers; return its size in units of tolerance."""
    real, pair, Z, L = course.real, course.pair, course.Z, course.multipliers
    n = course.y.shape[0] - 1
    load, gamma, r = course.load, course.gamma, course.r
    for i in range(load.shape[1]):
        for k in range(load.shape[2]):
            one, two = _transformed(load[0, i, k], load[1, i, k], load[2, i, k])
            real.load[i, k], pair.load[i, k] = one, two
    for i in range(gamma.shape[1]):
        real.gamma[i], pair.gamma[i] = _transformed(gamma[0, i], gamma[1, i], gamma[2, i])
    for i in range(model.n_pos):
        real.r[i], pair.r[i] = _transformed(r[0, i], r[1, i], r[2, i])
    solve_pencil(model, course.frozen, real, MU / h)
    solve_pencil(model, course.frozen, pair, NU / h)
    size = 0.0
    for k in range(3):
        t0, t1, t2 = T[k, 0], T[k, 1], T[k, 2]
        for i in range(n):
            c = pair.delta[i]
            change = t0 * real.delta[i] + t1 * c.real + t2 * c.imag
            course.stage[i] = change
            Z[k, i] += change
        for i in range(L.shape[1]):
            c = pair.mu[i]
            L[k, i] += t0 * real.mu[i] + t1 * c.real + t2 * c.imag
        course.stage[n] = 0.0
        size = max(size, _norm(options, course.stage, course.weight))
    return size


@inlined
def _transformed(a: float, b: float, c: float) -> tuple[float, complex]:
    """T^-1 (a, b, c): the real part and the pair of the stages' equations."""
    TI = T_INVERSE
    one = TI[0, 0] * a + TI[0, 1] * b + TI[0, 2] * c
    two = TI[1, 0] * a + TI[1, 1] * b + TI[1, 2] * c
    three = TI[2, 0] * a + TI[2, 1] * b + TI[2, 2] * c
    return one, complex(two, three)


@inlined
def _norm(options: Options, a: Array, weight: Array) -> float:
    """Largest of the blocks' root mean squares; see integrate/norm.py."""
    largest = 0.0
    for b in range(options.block_starts.shape[0] - 1):
        s = 0.0
        for i in range(options.block_starts[b], options.block_starts[b + 1]):
            s += (a[i] * weight[i]) ** 2
        s /= options.block_starts[b + 1] - options.block_starts[b]
        if not s <= largest:
            largest = s
    return float(np.sqrt(largest))


@inlined
def _finite(a: Array) -> bool:
    s = 0.0
    for i in range(a.shape[0]):
        s += abs(a[i])
    return bool(s < 1e300)
