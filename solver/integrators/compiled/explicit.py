"""Explicit Runge-Kutta methods: memory, stages, and the step loop for mechanisms."""

from typing import NamedTuple

import numpy as np

from ...dynamics.analysis.projection import project
from ...dynamics.evaluation.accelerations import derivative_into
from ...dynamics.model.model import Model, Work, new_work
from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, lean, structure
from ..generic.dormand_prince import Tableau
from ..generic.explicit import (
    CAUTION,
    FAR_BELOW,
    RELAX,
    RELAX_FAR,
    SAFETY,
    STIFF_TESTS,
    TEST_EVERY,
)
from .step_control import (
    ARRIVED,
    ERROR_LAST,
    EVALUATIONS,
    GOES_ON,
    ILL,
    N_CLOCK,
    N_COUNT,
    NEXT,
    NONE,
    OFF,
    PAUSED,
    STEPS,
    TIME,
    TOO_ROUGH,
    TOO_SMALL,
    TROUBLE,
    Ends,
    Options,
    count_step,
    finite,
    keep_end,
    next_step,
    norm,
    refuse,
    set_weights,
)

# Entries of `clock` after those of every loop (step_control.py): whether the last attempt was
# refused, the beginning of the last step; steps in a row that look stiff and that do not, and the
# step at which they were so many that a hint is due; the largest step after one that was refused.
REFUSED_LAST, TIME_OLD, SUSPECT, CLEAR, STIFF_TIME, STIFF_STEP, LARGEST = 4, 5, 6, 7, 8, 9, 10


@structure
class ExplicitWorkspace(NamedTuple):
    """Memory of a run, which a call takes up where the last one left it."""

    work: Work
    K: Array  # (s + 1 + e, n) derivatives at the stages, the new state, the extra stages
    y: Array  # (n,) state
    f: Array  # (n,) its rate
    y_old: Array  # (n,) state at the beginning of the last step
    F: Array  # (d + 3 or d, n) polynomial of the last step
    y_new: Array  # (n,)
    point: Array  # (n,) the last stage's state
    error: Array  # (n,)
    weight: Array  # (n,)
    step: Array  # (n_vel,) of the projection
    before: Array  # (n_pos,)
    clock: Array  # (N_CLOCK,)
    counts: IntArray  # (N_COUNT,)


def new_explicit_workspace(
    model: Model, tableau: Tableau, t: float, y: Array, rate: Array, first_step: float
) -> ExplicitWorkspace:
    """Return memory for a run from state y (n,) at t [s], with its rate."""
    n, d = y.shape[0], tableau.D.shape[0]
    workspace = ExplicitWorkspace(
        new_work(model),
        np.zeros((tableau.D.shape[1], n)),
        y.copy(),
        rate.copy(),
        y.copy(),
        np.zeros((d if tableau.first_same_as_last else d + 3, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(model.n_vel),
        np.zeros(model.n_pos),
        np.zeros(N_CLOCK),
        np.zeros(N_COUNT, dtype=np.int64),
    )
    workspace.clock[TIME], workspace.clock[NEXT], workspace.clock[ERROR_LAST] = t, first_step, 1e-4
    workspace.clock[LARGEST] = 1e300
    return workspace


@lean
def fill_stages(
    model: Model,
    work: Work,
    A: Array,
    C: Array,
    t: float,
    y: Array,
    h: float,
    K: Array,
    point: Array,
) -> None:
    """Fill K[1:s] (s, n) with the derivatives at the stages of a step h from (t, y); K[0] is there.

    Parameters
    ----------
    A, C : (s, s), (s,) of the tableau
    point : (n,) memory; holds the last stage's state at the end
    """
    n = y.shape[0]
    for i in range(1, C.shape[0]):
        for k in range(n):
            point[k] = A[i, 0] * K[0, k]
        for j in range(1, i):
            a = A[i, j]
            if a != 0.0:
                for k in range(n):
                    point[k] += a * K[j, k]
        for k in range(n):
            point[k] = y[k] + h * point[k]
        derivative_into(model, work, t + C[i] * h, point, K[i])


@lean
def advance_explicit(
    model: Model,
    options: Options,
    tableau: Tableau,
    workspace: ExplicitWorkspace,
    most_steps: int,
    times: Array,
    rows: Array,
    filled: int,
    ends: Ends,
) -> tuple[int, int]:
    """Take steps until t_end or `most_steps` accepted ones; see `advance` (radau.py)."""
    clock, counts, work, K = workspace.clock, workspace.counts, workspace.work, workspace.K
    y, y_new, s, n = workspace.y, workspace.y_new, tableau.B.shape[0], workspace.y.shape[0]
    fixed = options.fixed_step > 0.0
    taken = 0
    while clock[TIME] < options.t_end:
        if taken == most_steps:
            return PAUSED, filled
        t = clock[TIME]
        h, t_new, too_small = next_step(options, clock)
        if too_small:
            return TOO_SMALL, filled
        for i in range(n):
            K[0, i] = workspace.f[i]
        fill_stages(model, work, tableau.A, tableau.C, t, y, h, K, workspace.point)
        counts[EVALUATIONS] += s - 1
        for i in range(n):
            sum_of = 0.0
            for j in range(s):
                sum_of += tableau.B[j] * K[j, i]
            y_new[i] = y[i] + h * sum_of
        if tableau.first_same_as_last:
            derivative_into(model, work, t_new, y_new, K[s])
            counts[EVALUATIONS] += 1
        error = _error(options, tableau, workspace, h)

        counts[TROUBLE] = NONE
        factor = 0.25
        if not error < np.inf:
            counts[TROUBLE] = ILL
        elif error > 1.0 and not fixed:
            counts[TROUBLE] = TOO_ROUGH
            factor = max(tableau.min_factor, SAFETY * error ** (-1.0 / tableau.exponent))
            clock[LARGEST] = CAUTION * h
        elif options.closes:
            reached = project(model, work, t_new, y_new, workspace.step, workspace.before)
            if not (reached and finite(y_new)):
                counts[TROUBLE] = OFF
        if counts[TROUBLE] == NONE and (options.closes or not tableau.first_same_as_last):
            derivative_into(model, work, t_new, y_new, K[s])
            counts[EVALUATIONS] += 1
            if not finite(K[s]):
                counts[TROUBLE] = ILL
        if counts[TROUBLE] != NONE:
            clock[REFUSED_LAST] = 1.0
            code = refuse(options, clock, counts, h, factor)
            if code != GOES_ON:
                return code, filled
            continue

        error = max(error, 1e-8)
        proportional = 1.0 / tableau.exponent - 0.75 * tableau.integral
        factor = SAFETY * error**-proportional * clock[ERROR_LAST] ** tableau.integral
        largest = 1.0 if clock[REFUSED_LAST] > 0.0 else tableau.max_factor
        clock[NEXT] = min(h * min(largest, max(tableau.min_factor, factor)), clock[LARGEST])
        clock[LARGEST] *= RELAX if error > FAR_BELOW else RELAX_FAR
        clock[ERROR_LAST], clock[REFUSED_LAST] = max(error, 1e-4), 0.0
        if clock[SUSPECT] > 0.0 or counts[STEPS] % TEST_EVERY == 0:
            _test_stiffness(options, tableau, workspace, h)
        for i in range(n):
            workspace.y_old[i], y[i] = y[i], y_new[i]
            workspace.f[i] = K[s, i]
        clock[TIME_OLD] = t
        count_step(clock, counts, h, t_new)
        keep_end(ends, taken, t_new, y)
        taken += 1
        known = False
        while filled < times.shape[0] and times[filled] <= t_new:
            row = rows[filled]
            if times[filled] == t_new:
                for i in range(n):
                    row[i] = y[i]
            else:
                if not known:
                    fill_polynomial(model, tableau, workspace)
                    known = True
                _interpolate(tableau, workspace, (times[filled] - t) / h, row)
                if options.closes:
                    _close_row(model, workspace, times[filled], row)
            filled += 1
    return ARRIVED, filled


@inlined
def _error(options: Options, tableau: Tableau, workspace: ExplicitWorkspace, h: float) -> float:
    """Local error in units of the tolerance."""
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
            clock[STIFF_TIME], clock[STIFF_STEP] = clock[TIME], h
    elif clock[SUSPECT] > 0.0:
        clock[CLEAR] += 1.0
        if clock[CLEAR] == 6.0:
            clock[SUSPECT] = 0.0


@lean
def fill_polynomial(model: Model, tableau: Tableau, workspace: ExplicitWorkspace) -> None:
    """Fill F with the polynomial of the last step, after the extra stages that it needs."""
    K, F, clock, s = workspace.K, workspace.F, workspace.clock, tableau.B.shape[0] + 1
    t, h, n = clock[TIME_OLD], clock[TIME] - clock[TIME_OLD], workspace.y.shape[0]
    extra = tableau.C_extra.shape[0]
    for e in range(extra):
        for i in range(n):
            sum_of = 0.0
            for j in range(s + e):
                sum_of += tableau.A_extra[e, j] * K[j, i]
            workspace.point[i] = workspace.y_old[i] + h * sum_of
        derivative_into(
            model, workspace.work, t + tableau.C_extra[e] * h, workspace.point, K[s + e]
        )
    workspace.counts[EVALUATIONS] += extra
    first = F.shape[0] - tableau.D.shape[0]
    for i in range(n):
        if first == 3:
            step = workspace.y[i] - workspace.y_old[i]
            F[0, i] = step
            F[1, i] = h * K[0, i] - step
            F[2, i] = step - h * K[s - 1, i] - F[1, i]
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
def _close_row(model: Model, workspace: ExplicitWorkspace, t: float, row: Array) -> None:
    """Bring a row (n,) of the output onto the constraints; left as it is where none are near."""
    for i in range(row.shape[0]):
        workspace.point[i] = row[i]
    if project(model, workspace.work, t, workspace.point, workspace.step, workspace.before):
        for i in range(row.shape[0]):
            row[i] = workspace.point[i]
