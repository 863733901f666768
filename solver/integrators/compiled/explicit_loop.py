"""Explicit Runge-Kutta methods: memory, stages, and the step loop for mechanisms."""

from typing import Annotated, NamedTuple

import numpy as np

from ...dynamics.analysis.projection import project
from ...dynamics.evaluation.accelerations import derivative_at, derivative_into, sample_into
from ...dynamics.model.model import Model, Workspace
from ...math.arrays import Array, IntArray, zeros_of
from ...math.compiled import inlined, lean, structure
from ..generic.dormand_prince import Tableau
from . import step_control as codes
from .step_control import (
    Ends,
    Options,
    at_instant,
    count_step,
    finite,
    keep_end,
    next_step,
    norm,
    refuse,
    set_weights,
)

SAFETY = 0.9
# Of a step that was refused: the largest that follows, and its growth with each step. Where the
# stability limits the steps, the error says so only beyond it (docs/measurements.md). Errors far
# below one say that what was rough is over.
CAUTION, RELAX, RELAX_FAR, FAR_BELOW = 0.9, 1.02, 2.0, 1e-3
STIFF_TESTS = 15  # in a row, before the hint is given
TEST_EVERY = 25  # steps, while nothing looks stiff
# Entries of `clock` after those of every loop (step_control.py): whether the last attempt was
# refused, the beginning of the last step; steps in a row that look stiff and that do not, and the
# step at which they were so many that a hint is due; the largest step after one that was refused.
REFUSED_LAST, TIME_OLD, SUSPECT, CLEAR, STIFF_TIME, STIFF_STEP, LARGEST = 4, 5, 6, 7, 8, 9, 10


@structure
class ExplicitWorkspace(NamedTuple):
    """Memory of a run, which a call takes up where the last one left it."""

    K: Annotated[Array, "stages, n"]  # derivatives at the stages, the new state, the extra stages
    y: Array  # (n,) state
    f: Array  # (n,) its rate
    y_old: Array  # (n,) state at the beginning of the last step
    F: Annotated[Array, "powers, n"]  # polynomial of the last step
    y_new: Annotated[Array, "n"]
    point: Annotated[Array, "n"]  # the last stage's state
    error: Annotated[Array, "n"]
    weight: Annotated[Array, "n"]
    step: Annotated[Array, "n_vel"]  # of the projection; (0,) without a model
    before: Annotated[Array, "n_pos"]
    clock: Annotated[Array, "clock"]
    counts: Annotated[IntArray, "count"]


def new_explicit_workspace(
    tableau: Tableau, t: float, y: Array, rate: Array, sizes: tuple[int, int] = (0, 0)
) -> ExplicitWorkspace:
    """Return memory for a run from state y (n,) at t [s], with its rate; sizes (n_vel, n_pos).

    Parameters
    ----------
    tableau : coefficients of the method
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    rate : dy/dt of that state (n,)
    sizes : n_vel and n_pos of a mechanism
    """
    n, d = y.shape[0], tableau.D.shape[0]
    powers = d if tableau.first_same_as_last else d + 3
    memory = {"n": n, "stages": tableau.D.shape[1], "powers": powers}
    memory |= {"n_vel": sizes[0], "n_pos": sizes[1], "clock": codes.N_CLOCK, "count": codes.N_COUNT}
    given = {"y": y.copy(), "f": rate.copy(), "y_old": y.copy()}
    workspace = zeros_of(ExplicitWorkspace, memory, **given)
    workspace.clock[codes.TIME], workspace.clock[codes.ERROR_LAST], workspace.clock[LARGEST] = (
        t,
        1e-4,
        1e300,
    )
    return workspace


@inlined
def step_to(y: Array, weights: Array, count: int, h: float, K: Array, out: Array) -> None:
    """Fill out (n,) with y + h times the sum of the first rows of K (s, n), weighed.

    Parameters
    ----------
    y : state at the begin of the step (n,)
    weights : coefficients of the stages (count or more,)
    count : number of stages used
    h : step size [s]
    K : derivatives at the stages (s, n)
    out : y + h sum, (n,), to fill
    """
    n = y.shape[0]
    for k in range(n):
        out[k] = weights[0] * K[0, k]
    for j in range(1, count):
        a = weights[j]
        if a != 0.0:
            for k in range(n):
                out[k] += a * K[j, k]
    for k in range(n):
        out[k] = y[k] + h * out[k]


@lean
def fill_stages(
    model: Model,
    work: Workspace,
    tableau: Tableau,
    workspace: ExplicitWorkspace,
    t: float,
    h: float,
) -> None:
    """Fill K[1:s] with the derivatives at the stages of a step h from t; K[0] is there.

    `point` holds the last stage's state at the end.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    tableau : coefficients of the method
    workspace : memory of the run
    t : begin of the step [s]
    h : step size [s]
    """
    K, point = workspace.K, workspace.point
    for i in range(1, tableau.C.shape[0]):
        step_to(workspace.y, tableau.A[i], i, h, K, point)
        derivative_into(model, work, t + tableau.C[i] * h, point, K[i])


@inlined
def attempt_step(
    model: Model,
    work: Workspace,
    options: Options,
    tableau: Tableau,
    workspace: ExplicitWorkspace,
    h: float,
    t_new: float,
) -> tuple[float, float]:
    """Try a step; return its error in units of the tolerance, and the factor after a refusal.

    TROUBLE tells whether it is refused; `y_new` is its end.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    options : tolerances and options of the run (step_control.py)
    tableau : coefficients of the method
    workspace : memory of the run
    h : step size [s]
    t_new : end of the step [s]
    """
    counts, K, y_new, s = workspace.counts, workspace.K, workspace.y_new, tableau.B.shape[0]
    copy(workspace.f, K[0])
    fill_stages(model, work, tableau, workspace, workspace.clock[codes.TIME], h)
    step_to(workspace.y, tableau.B, s, h, K, y_new)
    counts[codes.EVALUATIONS] += s - 1
    if tableau.first_same_as_last:
        derivative_into(model, work, t_new, y_new, K[s])
        counts[codes.EVALUATIONS] += 1
    error, factor = local_error(options, tableau, workspace, h), 0.25
    counts[codes.TROUBLE] = codes.NONE
    if not error < np.inf:
        counts[codes.TROUBLE] = codes.ILL
    elif error > 1.0 and not options.fixed_step > 0.0:
        counts[codes.TROUBLE] = codes.TOO_ROUGH
        factor = max(tableau.min_factor, SAFETY * error ** (-1.0 / tableau.exponent))
        workspace.clock[LARGEST] = CAUTION * h
    elif options.closes:
        reached = project(model, work, t_new, y_new, workspace.step, workspace.before)
        if not (reached and finite(y_new)):
            counts[codes.TROUBLE] = codes.OFF
    if counts[codes.TROUBLE] == codes.NONE and (options.closes or not tableau.first_same_as_last):
        derivative_at(model, work, t_new, y_new, K[s], options.closes)
        counts[codes.EVALUATIONS] += 1
        if not finite(K[s]):
            counts[codes.TROUBLE] = codes.ILL
    if counts[codes.TROUBLE] != codes.NONE:
        workspace.clock[REFUSED_LAST] = 1.0
    return error, factor


@inlined
def copy(a: Array, out: Array) -> None:
    """Fill out (n,) with a (n,)."""
    for i in range(a.shape[0]):
        out[i] = a[i]


@lean
def accept_step(
    options: Options,
    tableau: Tableau,
    workspace: ExplicitWorkspace,
    error: float,
    h: float,
    t_new: float,
) -> None:
    """Make the end of the step the state, and choose the next one.

    By proportional-integral control: its factor is SAFETY err^-a err_last^b. An order a steadies
    it and b damps the change, which saves refusals where the error varies along the motion.

    Parameters
    ----------
    options : tolerances and options of the run (step_control.py)
    tableau : coefficients of the method
    workspace : memory of the run
    error : error of the step in units of the tolerance
    h : step size [s]
    t_new : end of the step [s]
    """
    clock, counts, error = workspace.clock, workspace.counts, max(error, 1e-8)
    proportional = 1.0 / tableau.exponent - 0.75 * tableau.integral
    factor = SAFETY * error**-proportional * clock[codes.ERROR_LAST] ** tableau.integral
    largest = 1.0 if clock[REFUSED_LAST] > 0.0 else tableau.max_factor
    clock[codes.NEXT] = min(h * min(largest, max(tableau.min_factor, factor)), clock[LARGEST])
    clock[LARGEST] *= RELAX if error > FAR_BELOW else RELAX_FAR
    clock[codes.ERROR_LAST], clock[REFUSED_LAST] = max(error, 1e-4), 0.0
    if clock[SUSPECT] > 0.0 or counts[codes.STEPS] % TEST_EVERY == 0:
        _test_stiffness(options, tableau, workspace, h)
    copy(workspace.y, workspace.y_old)
    copy(workspace.y_new, workspace.y)
    copy(workspace.K[tableau.B.shape[0]], workspace.f)
    clock[TIME_OLD] = clock[codes.TIME]
    count_step(clock, counts, h, t_new)


@lean
def advance_explicit(
    model: Model,
    work: Workspace,
    options: Options,
    tableau: Tableau,
    workspace: ExplicitWorkspace,
    most_steps: int,
    times: Array,
    rows: Array,
    filled: int,
    ends: Ends,
) -> tuple[int, int]:
    """Take steps until END or `most_steps` accepted ones; see `advance` (radau_loop.py).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    options : tolerances and options of the run (step_control.py)
    tableau : coefficients of the method
    workspace : memory of the run
    most_steps : number of accepted steps after which the call returns
    times : output times (k,) [s]
    rows : solution at these times (k, n), to fill
    filled : number of rows filled before
    ends : memory of accepted step ends
    """
    clock, counts, y = workspace.clock, workspace.counts, workspace.y
    taken = 0
    while clock[codes.TIME] < clock[codes.END]:
        if taken == most_steps:
            return codes.PAUSED, filled
        t = clock[codes.TIME]
        h, t_new, too_small = next_step(options, clock)
        if too_small:
            return codes.TOO_SMALL, filled
        error, factor = attempt_step(model, work, options, tableau, workspace, h, t_new)
        if counts[codes.TROUBLE] != codes.NONE:
            code = refuse(options, clock, counts, h, factor)
            if code != codes.GOES_ON:
                return code, filled
            continue
        accept_step(options, tableau, workspace, error, h, t_new)
        known = False
        while filled < times.shape[0] and times[filled] <= t_new:
            row = rows[filled]
            if times[filled] == t_new:
                copy(y, row)
            else:
                if not known:
                    fill_polynomial(model, work, tableau, workspace)
                    known = True
                _interpolate(tableau, workspace, (times[filled] - t) / h, row)
                if options.closes:
                    _close_row(model, work, workspace, times[filled], row)
            filled += 1
        if at_instant(options, clock):
            sample_into(model, work, t_new, y, workspace.f, not known)
            counts[codes.EVALUATIONS] += 1
        keep_end(ends, taken, t_new, y)
        taken += 1
    return codes.ARRIVED, filled


@lean
def local_error(
    options: Options, tableau: Tableau, workspace: ExplicitWorkspace, h: float
) -> float:
    """Local error in units of the tolerance.

    Parameters
    ----------
    options : tolerances and options of the run (step_control.py)
    tableau : coefficients of the method
    workspace : memory of the run
    h : step size [s]
    """
    set_weights(options, workspace.y, workspace.y_new, workspace.weight)
    _combine(tableau.E[0], workspace)
    first = norm(options, workspace.error, workspace.weight)
    if tableau.first_same_as_last:
        return h * first
    _combine(tableau.E[1], workspace)
    second = norm(options, workspace.error, workspace.weight)
    if first == 0.0:
        return 0.0 * second
    return float(h * first * first / np.sqrt(first * first + 0.01 * second * second))


@inlined
def _combine(E: Array, workspace: ExplicitWorkspace) -> None:
    """Fill workspace.error with E K."""
    for i in range(workspace.error.shape[0]):
        sum_of = 0.0
        for j in range(E.shape[0]):
            sum_of += E[j] * workspace.K[j, i]
        workspace.error[i] = sum_of


@inlined
def _test_stiffness(
    options: Options, tableau: Tableau, workspace: ExplicitWorkspace, h: float
) -> None:
    """Compare |h lambda|, seen from the last stage (also at t_new), with the limit."""
    clock, s, K, n = workspace.clock, tableau.B.shape[0], workspace.K, workspace.y.shape[0]
    set_weights(options, workspace.y_new, workspace.y_new, workspace.weight)
    for i in range(n):
        workspace.error[i] = workspace.y_new[i] - workspace.point[i]
    distance = norm(options, workspace.error, workspace.weight)
    if distance == 0.0:
        return
    for i in range(n):
        workspace.error[i] = K[s, i] - K[s - 1, i]
    if h * norm(options, workspace.error, workspace.weight) / distance > tableau.stability_limit:
        clock[SUSPECT] += 1.0
        clock[CLEAR] = 0.0
        if clock[SUSPECT] == STIFF_TESTS and clock[STIFF_STEP] == 0.0:
            clock[STIFF_TIME], clock[STIFF_STEP] = clock[codes.TIME], h
    elif clock[SUSPECT] > 0.0:
        clock[CLEAR] += 1.0
        if clock[CLEAR] == 6.0:
            clock[SUSPECT] = 0.0


@lean
def fill_polynomial(
    model: Model, work: Workspace, tableau: Tableau, workspace: ExplicitWorkspace
) -> None:
    """Fill F with the polynomial of the last step, after the extra stages that it needs.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    tableau : coefficients of the method
    workspace : memory of the run
    """
    K, clock, point, s = workspace.K, workspace.clock, workspace.point, tableau.B.shape[0] + 1
    t, h = clock[TIME_OLD], clock[codes.TIME] - clock[TIME_OLD]
    for e in range(tableau.C_extra.shape[0]):
        step_to(workspace.y_old, tableau.A_extra[e], s + e, h, K, point)
        derivative_into(model, work, t + tableau.C_extra[e] * h, point, K[s + e])
    workspace.counts[codes.EVALUATIONS] += tableau.C_extra.shape[0]
    set_polynomial(tableau, workspace, h)


@lean
def set_polynomial(tableau: Tableau, workspace: ExplicitWorkspace, h: float) -> None:
    """Fill F from all stages of the last step.

    Parameters
    ----------
    tableau : coefficients of the method
    workspace : memory of the run
    h : size of the last step [s]
    """
    K, F, s = workspace.K, workspace.F, tableau.B.shape[0]
    first = F.shape[0] - tableau.D.shape[0]
    for i in range(workspace.y.shape[0]):
        if first == 3:
            step = workspace.y[i] - workspace.y_old[i]
            F[0, i] = step
            F[1, i] = h * K[0, i] - step
            F[2, i] = step - h * K[s, i] - F[1, i]
        for d in range(tableau.D.shape[0]):
            sum_of = 0.0
            for j in range(K.shape[0]):
                sum_of += tableau.D[d, j] * K[j, i]
            F[first + d, i] = h * sum_of


@inlined
def _interpolate(tableau: Tableau, workspace: ExplicitWorkspace, x: float, out: Array) -> None:
    """Fill out (n,) with the polynomial of the last step at its part x, 0 to 1."""
    F, last = workspace.F, workspace.F.shape[0] - 1
    nested = F.shape[0] > tableau.D.shape[0]
    for i in range(out.shape[0]):
        change = 0.0
        for k in range(last + 1):
            j = last - k
            change = (change + F[j, i]) * (1.0 - x if nested and j % 2 == 1 else x)
        out[i] = workspace.y_old[i] + change


@inlined
def _close_row(
    model: Model, work: Workspace, workspace: ExplicitWorkspace, t: float, row: Array
) -> None:
    """Bring a row (n,) of the output onto the constraints; left as it is where none are near."""
    copy(row, workspace.point)
    if project(model, work, t, workspace.point, workspace.step, workspace.before):
        copy(workspace.point, row)
