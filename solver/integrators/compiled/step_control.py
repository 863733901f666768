"""What the compiled step loops share: options, outcomes, the error norm, the control of steps."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, structure

# What a call comes back with; and, of an attempt refused, that a shorter one follows.
ARRIVED, PAUSED, TOO_SMALL, NOT_FINITE, REFUSED, GOES_ON = 0, 1, 2, 3, 4, 5
# Entries of `clock`: time, next step, last step; its error and Newton's rate of convergence; step
# of the last iteration that failed; frequency above which errors do not count [rad/s], 0: none,
# below 0: those of velocities alone; last step that was too rough; growth of the limit with the
# next step, after an iteration failed.
TIME, NEXT, TAKEN = 0, 1, 2
ERROR_LAST, RATE, LIMIT, CUTOFF, ROUGH, GROWTH = 3, 4, 5, 6, 7, 8
# Of the choice of Newton's matrix (tension.py): whether tension is in it; attempts under judgement,
# those that the iteration refused for tension, when they began; pace of the other [s per attempt].
TENSE, TRIED, REFUSALS, SINCE, OTHER = 9, 10, 11, 12, 13
KINK = 14  # number of the first kink of a law of time that is still to come
INSTANT = 15  # number of the first instant of sampling that is still to come
END = 16  # where the loop comes back [s]
BEGUN = 17  # number of the steps before the last start of `radau`
LENGTH = 18  # of the last accepted step [s]; TAKEN is 0 where it is to be forgotten
N_CLOCK = 19
# Entries of `counts`.
STEPS, REJECTED, EVALUATIONS, FACTORISATIONS, BAD, TROUBLE = 0, 1, 2, 3, 4, 5
JACOBIANS = 6
BECAUSE = 7  # first of the refusals by value of TROUBLE
N_COUNT = 12
# Values of TROUBLE: why the last attempt was refused.
NONE, NEWTON, TOO_ROUGH, ILL, OFF = 0, 1, 2, 3, 4
SMALLEST = 1e-300  # step, whatever the time [s]
MAX_NOT_FINITE = 25  # attempts in a row


@structure
class Options(NamedTuple):
    """What does not change during a run."""

    rtol: float
    atol: Array  # (n,)
    block_starts: IntArray  # (b + 1,) of the error norm
    max_step: float
    min_step: float
    fixed_step: float  # 0: error control
    kinks: Array  # (k,) times at which a step ends, ascending [s],
    sharp: NDArray[np.bool_]  # (k,) and whether forces have other rates behind them
    instants: Array  # (k,) times at which the loop samples states, ascending [s]
    closes: bool  # bring every step back onto the constraints


@structure
class Ends(NamedTuple):
    """Buffer for accepted steps of one call; empty if they are not requested."""

    t: Array  # (k,) their ends [s]
    y: Array  # (k, n)
    Z: Array  # (k, 3, n) changes at the stages of `radau`; empty if only ends are requested
    multipliers: Array  # (k, 3, n_r) at the stages


@inlined
def keep_end(ends: Ends, k: int, t: float, y: Array) -> None:
    """Keep the end of step k of a call.

    Parameters
    ----------
    ends : memory of accepted step ends
    k : number of the step in the call
    t : end of the step [s]
    y : state (n,), as in dynamics/model/model.py
    """
    if k < ends.t.shape[0]:
        ends.t[k] = t
        for i in range(y.shape[0]):
            ends.y[k, i] = y[i]


@inlined
def next_step(options: Options, clock: Array) -> tuple[float, float, bool]:
    """Return the next step [s], its end, and whether it is too small to be taken.

    Within the largest step, on the next kink or END exactly, no sliver before it.
    """
    kinks, k = options.kinks, int(clock[KINK])
    while k < kinks.shape[0] and kinks[k] <= clock[TIME]:
        k += 1
    clock[KINK] = k
    instants, i = options.instants, int(clock[INSTANT])
    while i < instants.shape[0] and instants[i] <= clock[TIME]:
        i += 1
    clock[INSTANT] = i
    end = clock[END]
    if i < instants.shape[0]:
        end = min(end, instants[i])
    t, h, stretch = clock[TIME], clock[NEXT], 1.01
    if options.fixed_step > 0.0:
        h, stretch = options.fixed_step, 1.0 + 1e-6
    h = min(h, options.max_step)
    if k < kinks.shape[0] and kinks[k] < end:
        end = kinks[k]
        if options.fixed_step == 0.0 and h * stretch < end - t < 2.0 * h:
            h = 0.5 * (end - t)  # two alike, no sliver that the next steps must grow from
    if h * stretch >= end - t:
        return end - t, end, False
    return h, t + h, h < max(options.min_step, 2e-15 * abs(t), SMALLEST)


@inlined
def at_kink(options: Options, clock: Array) -> bool:
    """Return whether the step that `next_step` has returned begins where forces get other rates."""
    k = int(clock[KINK])
    return k > 0 and options.sharp[k - 1] and options.kinks[k - 1] == clock[TIME]


@inlined
def at_instant(options: Options, clock: Array) -> bool:
    """Return whether the step just counted ends at an instant of sampling."""
    i = int(clock[INSTANT])
    return i < options.instants.shape[0] and options.instants[i] == clock[TIME]


@inlined
def refuse(options: Options, clock: Array, counts: IntArray, h: float, shorter: float) -> int:
    """Count an attempt of h that failed, and leave the next size; say whether to go on.

    `shorter` is the factor of the next size where numbers are finite.

    Parameters
    ----------
    options : tolerances and options of the run (step_control.py)
    clock : times and factors of the step control (step_control.py)
    counts : counters of the run (step_control.py)
    h : step size [s]
    shorter : factor of the next step size where numbers are finite
    """
    counts[REJECTED] += 1
    counts[BECAUSE + counts[TROUBLE]] += 1
    if options.fixed_step > 0.0:
        return REFUSED
    if counts[TROUBLE] == ILL:
        counts[BAD] += 1
        if counts[BAD] > MAX_NOT_FINITE:
            return NOT_FINITE
        shorter = 0.1
    clock[NEXT] = h * shorter
    return GOES_ON


@inlined
def count_step(clock: Array, counts: IntArray, h: float, t_new: float) -> None:
    """Count an accepted step of h to t_new.

    Parameters
    ----------
    clock : times and factors of the step control (step_control.py)
    counts : counters of the run (step_control.py)
    h : step size [s]
    t_new : end of the step [s]
    """
    clock[TAKEN], clock[LENGTH], clock[TIME] = h, h, t_new
    counts[STEPS] += 1
    counts[BAD] = 0


@inlined
def set_weights(options: Options, a: Array, b: Array, weight: Array) -> None:
    """Fill weight (n,) with 1 / (atol + rtol max(|a|, |b|)).

    Parameters
    ----------
    options : tolerances and options of the run (step_control.py)
    a : values at the begin of the step (n,)
    b : values at its end (n,)
    weight : 1 / tolerance (n,), to fill
    """
    for i in range(a.shape[0]):
        weight[i] = 1.0 / (options.atol[i] + options.rtol * max(abs(a[i]), abs(b[i])))


@inlined
def norm(options: Options, a: Array, weight: Array) -> float:
    """Largest of the blocks' root mean squares, nan if there is one; see generic/norm.py.

    Parameters
    ----------
    options : tolerances and options of the run (step_control.py)
    a : vector (n,)
    weight : 1 / tolerance (n,)
    """
    largest = 0.0
    for b in range(options.block_starts.shape[0] - 1):
        s = 0.0
        for i in range(options.block_starts[b], options.block_starts[b + 1]):
            s += (a[i] * weight[i]) ** 2
        s /= options.block_starts[b + 1] - options.block_starts[b]
        if s > largest or s != s:  # nan stays
            largest = s
    return float(np.sqrt(largest))


@inlined
def largest_component(a: Array, weight: Array) -> int:
    """Component of the largest of a (n,) in its weight."""
    most, at = -1.0, 0
    for i in range(a.shape[0]):
        size = abs(a[i] * weight[i])
        if size > most:
            most, at = size, i
    return at


@inlined
def finite(a: Array) -> bool:
    """Return whether no number is inf or nan."""
    s = 0.0
    for i in range(a.shape[0]):
        s += abs(a[i])
    return bool(s < 1e300)
