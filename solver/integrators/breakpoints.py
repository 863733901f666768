"""Instants at which laws of time break, where steps end, and the longest step.

A step that begins and ends at rest does not see a pulse between its stages: the error estimate
is zero, and so is the reason to make the step shorter. No step goes over a break, so that each one
sees what comes next (docs/adr/0053).
"""

from collections.abc import Callable
from functools import partial
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dynamics.elements.joints.contract import Drive
from ..dynamics.elements.joints.table import CONSTRAINTS, NAMES
from ..dynamics.model.model import Model, Quantities
from ..math.arrays import Array, distinct
from ..math.expressions import operations as op
from ..math.expressions.operations import TIME
from ..math.expressions.ranges import TermRange, curve_ranges, parts

MOST_BREAKS = 2000  # of a table at which steps end; one with more is looked at in cells
ROUNDING = 1e-13  # of the largest value: a point on the curve through its neighbours
JUMPS = 1e-6  # of the largest value or derivative: less is continuous
EXPRESSION = 200  # steps at least where an expression reads the time
# Cells of the run in which no part of a law varies by more than this share of its range.
VARIES, SHORTEST, FIRST_CELLS, SPLIT = 0.2, 1e-9, 16, 4
MOST_CELLS = 50_000
REMEMBERED = 64  # lengths of a cell in which a shorter one keeps steps short enough
GAP = 2.0**-46  # of the run: an instant of a jump is known to that
Range = tuple[Array, Array]  # bounds over k intervals, (k,) each
JUMPING = frozenset((op.LESS, op.LESS_EQUAL, op.SIGN, op.FLOOR))
RISING = frozenset((op.TANH, op.ARCTAN, op.ARCTAN2))  # steep and flat, with smooth bends between
Ranges = Callable[[Array, Array], list[Range]]  # bounds of every part of a law over intervals


class Breaks(NamedTuple):
    """Where laws of time break, and the longest step elsewhere [s]."""

    kinks: Array  # (k,) forces are continuous, their rates are not [s]
    narrow: Array  # (n,) forces may begin to vary fast, and a bit behind that [s]
    jumps: Array  # (m, 2) the instants before and after a jump of forces, GAP apart [s]
    longest: float
    unsearched: int  # expressions that may break at more instants than can be searched


def breaks(model: Model, t_end: float) -> Breaks:
    """Return the breaks of the laws of drives, loads, actuators, controllers and expressions.

    The longest step is t_end / EXPRESSION where an expression reads the time, other than at the
    instants of a sampled controller, t_end / MOST_BREAKS with a table of many breaks; or infinity.
    """
    kinks, narrow, jumps = [np.zeros(0)], [np.zeros(0)], [np.zeros((0, 2))]
    longest, unsearched = np.inf, 0
    driven = _of_drives(model)
    for law in range(len(model.law_start) - 1):
        own = slice(int(model.law_start[law]), int(model.law_start[law + 1]))
        times, coefficients = model.law_time[own], model.law_coefficient[own]
        if len(times) < 2 or model.quantities.law[law] >= 0:
            continue
        bends, leaps = _of_pieces(times, coefficients, drive=law in driven)
        if bends.size + leaps.size > MOST_BREAKS:
            ranges = partial(_of_curve, times, np.ascontiguousarray(coefficients))
            narrow.append(_narrowing(ranges, np.array([0.0, t_end])))
            bends, leaps = np.zeros(0), np.zeros(0)
            longest = min(longest, t_end / MOST_BREAKS)
        kinks.append(bends)
        jumps.append(np.column_stack([leaps - GAP * np.maximum(t_end, leaps), leaps]))
    programs = model.quantities.programs
    for p in distinct(programs_read(model)).tolist():
        if TIME not in programs.code[programs.start[p] : programs.start[p + 1]]:
            continue
        longest = min(longest, t_end / EXPRESSION)
        drive = p in {int(model.quantities.law[law]) for law in driven}
        parts = _of_program(partial(_of_time, model.quantities, p), t_end, drive=drive)
        if parts is None:
            unsearched += 1
            continue
        bends, begins, leaps = parts
        kinks.append(bends)
        narrow.append(begins)
        jumps.append(leaps)
    return Breaks(
        distinct(np.concatenate(kinks)),
        distinct(np.concatenate(narrow)),
        _apart(np.concatenate(jumps)),
        longest,
        unsearched,
    )


def _of_curve(times: Array, coefficients: Array, low: Array, high: Array) -> list[Range]:
    return [curve_ranges(times, coefficients, low, high)]


def _of_drives(model: Model) -> set[int]:
    """Return the laws that drives follow."""
    return {
        int(law)
        for kind, law in zip(model.joint_kind, model.joint_law, strict=True)
        if law >= 0 and isinstance(CONSTRAINTS[NAMES[kind]], Drive)
    }


def programs_read(model: Model) -> NDArray[np.int64]:
    """Return the expressions that the equations read at any time."""
    read = model.quantities
    used = np.concatenate([read.law, read.force, read.rate])
    return used[used >= 0]


def _of_pieces(times: Array, coefficients: Array, *, drive: bool) -> tuple[Array, Array]:
    """Return kinks and jumps between pieces; of a drive its acceleration counts as a force."""
    length = np.diff(times)
    degree = int(np.flatnonzero((coefficients != 0.0).any(axis=0)).max(initial=0))
    shorter = np.minimum(length, np.append(length[1:], length[-1]))
    largest = float(np.abs(coefficients[:, 0]).max())
    off, leap, power = np.zeros(len(length)), np.zeros(len(length), dtype=bool), 1.0
    for d in range(degree + 1):
        # the Taylor coefficient d of the piece before, at its end
        before = np.zeros(len(length))
        for i in range(degree, d - 1, -1):
            before += comb(i, d) * coefficients[:-1, i] * length ** (i - d)
        change = np.abs(coefficients[1:, d] - before)
        off = np.maximum(off, change * power)
        if d <= (2 if drive else 0):
            size = max(float(np.abs(before).max()), float(np.abs(coefficients[:, d]).max()))
            leap |= change > JUMPS * size
        power = power * shorter
    at, within = times[1:], (times[1:] > 0.0) & (off > ROUNDING * largest)
    return at[within & ~leap], at[within & leap]


def _of_time(quantities: Quantities, p: int, low: Array, high: Array) -> list[TermRange]:
    return parts(quantities.programs, p, low, high, quantities.stack)


def _of_program(
    parts_over: Callable[[Array, Array], list[TermRange]], t_end: float, *, drive: bool
) -> tuple[Array, Array, Array] | None:
    """Return kinks, narrow parts and jumps of an expression, of what reads the time alone in it.

    None: it may break in more than MOST_CELLS places.
    """

    def breaking(low: Array, high: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether an interval may have a kink, or a jump."""
        kink, jump = np.zeros(len(low), dtype=bool), np.zeros(len(low), dtype=bool)
        for part in parts_over(low, high):
            if drive or part.code in JUMPING:
                jump |= part.breaks
            elif part.code not in RISING:  # smooth: a narrow part
                kink |= part.breaks
        return kink, jump

    edges = np.linspace(0.0, t_end, FIRST_CELLS + 1)
    low, high = edges[:-1], edges[1:]
    while low.size and high[0] - low[0] > GAP * t_end:
        kink, jump = breaking(low, high)
        cells = kink | jump
        if np.count_nonzero(cells) > MOST_CELLS:
            return None  # everywhere, as of two functions that are the same
        low, high = _split(low[cells], high[cells], FIRST_CELLS)
    kink, jump = breaking(low, high)
    kink, jump = kink & (low > 0.0) & ~jump, jump & (low > 0.0)
    bends, leaps = high[kink], np.column_stack([low[jump], high[jump]])
    edges = distinct(np.concatenate([[0.0, t_end], bends, leaps.ravel()]))
    narrow = _narrowing(lambda a, b: [(part.low, part.high) for part in parts_over(a, b)], edges)
    return _first_of(bends, GAP * t_end), narrow, leaps


def _first_of(times: Array, gap: float) -> Array:
    """Return instants that are more than some gaps behind the one before."""
    times = distinct(times)
    return times[np.diff(times, prepend=-np.inf) > 4.0 * gap]


def _split(low: Array, high: Array, count: int) -> tuple[Array, Array]:
    """Return each interval in `count` parts."""
    edges = low[:, None] + (high - low)[:, None] * (np.arange(count + 1) / count)
    edges[:, -1] = high
    return edges[:, :-1].ravel(), edges[:, 1:].ravel()


def _apart(jumps: Array) -> Array:
    """Return jumps in ascending order, those that overlap as one."""
    intervals: list[list[float]] = []
    for before, after in sorted(map(tuple, jumps.tolist())):
        if intervals and before <= intervals[-1][1] + 2.0 * (after - before):
            intervals[-1][1] = max(intervals[-1][1], after)
        else:
            intervals.append([before, after])
    return np.array(intervals).reshape(-1, 2)


def _narrowing(ranges: Ranges, edges: Array) -> Array:
    """Return where a law begins to vary fast between edges (k,), and the first bit of it."""
    low, high = _quiet(ranges, edges)
    length = high - low
    edges_of_ranges = [np.zeros(0)]
    for i in np.flatnonzero(length[1:] < length[:-1] / 1.5) + 1:
        begin = int(np.searchsorted(high, low[i] - REMEMBERED * length[i]))
        if not (length[begin:i] <= 1.5 * length[i]).any():
            edges_of_ranges.append(np.array([low[i], high[i]]))
    return np.concatenate(edges_of_ranges)


def _quiet(ranges: Ranges, edges: Array) -> tuple[Array, Array]:
    """Return cells between edges (k,), in ascending order, in which a law varies little.

    However short: no part of it is taken for quiet by chance.
    """
    shortest, done, span = SHORTEST * (edges[-1] - edges[0]), [], None
    wide = np.diff(edges) > shortest  # not those of a jump
    low, high = _split(edges[:-1][wide], edges[1:][wide], FIRST_CELLS)
    while low.size:
        bounds, middle = ranges(low, high), 0.5 * (low + high)
        values = [each[0] for each in ranges(middle, middle)]
        if span is None:
            span = np.tile([np.inf, -np.inf], (len(bounds), 1))
        loud = np.zeros(low.size, dtype=bool)
        for own, (least, most), value in zip(span, bounds, values, strict=True):
            known = value[np.isfinite(value)]
            own[0] = min(own[0], known.min(initial=np.inf))
            own[1] = max(own[1], known.max(initial=-np.inf))
            outer = most - least > VARIES * max(own[1] - own[0], 0.0)  # of the whole at last
            loud |= outer
        loud &= high - low > shortest
        if np.count_nonzero(loud) * SPLIT > MOST_CELLS:
            # a part varies fast everywhere, and the steps are short for it where it counts
            loud &= outer
            loud[:] &= np.count_nonzero(loud) * SPLIT <= MOST_CELLS
        done.append(np.column_stack([low[~loud], high[~loud]]))
        low, high = _split(low[loud], high[loud], SPLIT)
    cells = np.concatenate(done)
    cells = cells[np.argsort(cells[:, 0])]
    return cells[:, 0], cells[:, 1]
