"""Radau IIA of order 5: the step loop for mechanisms with modes stiffer than the motion."""

from typing import NamedTuple

import numpy as np

from ..compiled import inlined, jit
from ..model import Model
from ..package.schema import Array, IntArray
from ..projection import project
from ..system import derivative_into
from ..workspace import Work, new_work
from .pencil import (
    Frozen,
    Pencil,
    factorise_pencil,
    freeze,
    new_frozen,
    new_pencil,
    solve_pencil,
)
from .tableau import ERROR, MU, NU, POWERS, T_INVERSE, C, T

MAX_ITERATIONS = 10
SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 8.0
KEEP = 1.2  # a change of step below this is not worth new factors

# What a call comes back with.
ARRIVED, PAUSED, TOO_SMALL, NOT_FINITE, REFUSED = 0, 1, 2, 3, 4
# Entries of `clock`.
TIME, NEXT, TAKEN, ERROR_LAST, TAKEN_LAST = 0, 1, 2, 3, 4
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
    f: Array  # (n,) its derivative
    y_old: Array  # (n,) state at the beginning of the last step
    Q: Array  # (3, n) polynomial of the last step
    Z: Array  # (3, n) changes at the stages
    W: Array  # (3, n) the same, transformed
    F: Array  # (3, n) derivatives at the stages
    stage: Array  # (n,)
    weight: Array  # (n,)
    r: Array  # (n,) right-hand sides and answers
    d: Array  # (n,)
    r_pair: Array  # (n,) complex
    d_pair: Array  # (n,) complex
    clock: Array  # (5,)
    counts: IntArray  # (7,)


@jit
def new_course(model: Model, t: float, y: Array, first_step: float) -> Course:
    """Return memory for a run from state y (n,) at time t [s]."""
    n = y.shape[0]
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
        np.zeros((3, n)),
        np.zeros((3, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n) * 1.0j,
        np.zeros(n) * 1.0j,
        np.zeros(5),
        np.zeros(7, dtype=np.int64),
    )
    course.clock[TIME], course.clock[NEXT], course.clock[ERROR_LAST] = t, first_step, 1.0
    derivative_into(model, course.work, t, y, course.f)
    freeze(model, course.work, y, course.frozen)
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
    real, pair = MU / h, NU / h
    factorise_pencil(model, course.frozen, course.real, real)
    factorise_pencil(model, course.frozen, course.pair, pair)
    counts[FACTORISATIONS] += 1
    _predict(course, h)
    for i in range(n):
        course.weight[i] = 1.0 / (options.atol[i] + options.rtol * abs(course.y[i]))
    iterations, rate = _newton(model, options, course, t, h, real, pair)
    if iterations == 0:
        clock[NEXT] = (0.1 if counts[TROUBLE] == ILL else 0.5) * h
        return False
    y, Z, stage = course.y, course.Z, course.stage
    # error of the embedded formula of order 3, with what is stiff divided out
    for i in range(n):
        course.r[i] = course.f[i] + _tilt(Z, i) / h
        stage[i] = y[i] + Z[2, i]
        scale = max(abs(y[i]), abs(stage[i]))
        course.weight[i] = 1.0 / (options.atol[i] + options.rtol * scale)
    solve_pencil(model, course.frozen, course.real, real, course.r, course.d)
    error = _norm(options, course.d, course.weight)
    if error > 1.0 and options.fixed_step == 0.0:
        # filtered once more: the first error of a stiff transient is too pessimistic
        for i in range(n):
            course.d[i] += y[i]
        derivative_into(model, course.work, t, course.d, course.r)
        counts[EVALUATIONS] += 1
        for i in range(n):
            course.r[i] += _tilt(Z, i) / h
        solve_pencil(model, course.frozen, course.real, real, course.r, course.d)
        error = _norm(options, course.d, course.weight)
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
        counts[EVALUATIONS] += 1
        if not project(model, course.work, t_new, stage):
            counts[TROUBLE] = OFF
            clock[NEXT] = 0.25 * h
            return False
    derivative_into(model, course.work, t_new, stage, course.r)
    counts[EVALUATIONS] += 1
    if not _finite(course.r):
        return _ill(course, h)
    for i in range(n):
        course.y_old[i] = y[i]
        y[i] = stage[i]
        course.f[i] = course.r[i]
        for k in range(3):
            q = POWERS[k, 0] * Z[0, i] + POWERS[k, 1] * Z[1, i] + POWERS[k, 2] * Z[2, i]
            course.Q[k, i] = q
    freeze(model, course.work, y, course.frozen)
    if clock[TAKEN] > 0.0:  # Gustafsson: errors that grow ask for more care
        growing = h / clock[TAKEN] * (clock[ERROR_LAST] / error) ** 0.25
        factor *= min(1.0, growing)
    factor = max(MIN_FACTOR, min(MAX_FACTOR, factor))
    if 1.0 <= factor < KEEP and rate < 0.1:
        factor = 1.0
    clock[NEXT] = h * factor
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
def _tilt(Z: Array, i: int) -> float:
    return ERROR[0] * Z[0, i] + ERROR[1] * Z[1, i] + ERROR[2] * Z[2, i]


@inlined
def _predict(course: Course, h: float) -> None:
    """Begin with the polynomial of the last step, continued; W follows from Z."""
    Z, W, Q, last = course.Z, course.W, course.Q, course.clock[TAKEN]
    for i in range(course.y.shape[0]):
        whole = Q[0, i] + Q[1, i] + Q[2, i]
        for k in range(3):
            Z[k, i] = 0.0
            if last > 0.0:
                x = 1.0 + C[k] * h / last
                Z[k, i] = x * (Q[0, i] + x * (Q[1, i] + x * Q[2, i])) - whole
        for k in range(3):
            TI = T_INVERSE
            W[k, i] = TI[k, 0] * Z[0, i] + TI[k, 1] * Z[1, i] + TI[k, 2] * Z[2, i]


@inlined
def _newton(
    model: Model,
    options: Options,
    course: Course,
    t: float,
    h: float,
    real: float,
    pair: complex,
) -> tuple[int, float]:
    """Solve for the stages; return iterations (0: failed) and their rate of convergence."""
    n, counts = course.y.shape[0], course.counts
    Z, W, F, TI = course.Z, course.W, course.F, T_INVERSE
    tolerance = max(2e-15 / options.rtol, min(0.01, options.rtol**0.5))
    size_last, rate = 0.0, 1.0
    for iteration in range(1, MAX_ITERATIONS + 1):
        for k in range(3):
            for i in range(n):
                course.stage[i] = course.y[i] + Z[k, i]
            derivative_into(model, course.work, t + C[k] * h, course.stage, F[k])
        counts[EVALUATIONS] += 3
        for i in range(n):
            course.r[i] = (
                TI[0, 0] * F[0, i] + TI[0, 1] * F[1, i] + TI[0, 2] * F[2, i] - real * W[0, i]
            )
            one = TI[1, 0] * F[0, i] + TI[1, 1] * F[1, i] + TI[1, 2] * F[2, i]
            two = TI[2, 0] * F[0, i] + TI[2, 1] * F[1, i] + TI[2, 2] * F[2, i]
            course.r_pair[i] = one + 1j * two - pair * (W[1, i] + 1j * W[2, i])
        solve_pencil(model, course.frozen, course.real, real, course.r, course.d)
        solve_pencil(model, course.frozen, course.pair, pair, course.r_pair, course.d_pair)
        size = 0.0
        for k in range(3):
            for i in range(n):
                d, c = course.d[i], course.d_pair[i]
                course.stage[i] = T[k, 0] * d + T[k, 1] * c.real + T[k, 2] * c.imag
                Z[k, i] += course.stage[i]
            size = max(size, _norm(options, course.stage, course.weight))
        for i in range(n):
            W[0, i] += course.d[i]
            W[1, i] += course.d_pair[i].real
            W[2, i] += course.d_pair[i].imag
        if not size < 1e300:
            counts[TROUBLE] = ILL
            counts[BAD] += 1
            return 0, 1.0
        if iteration > 1 and size_last > 0.0:
            rate = size / size_last
            left = MAX_ITERATIONS - iteration
            if rate >= 1.0 or rate**left / (1.0 - rate) * size > tolerance:
                break
        if size == 0.0 or (iteration > 1 and rate / (1.0 - rate) * size < tolerance):
            return iteration, rate
        size_last = size
    counts[TROUBLE] = NEWTON
    return 0, rate


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
