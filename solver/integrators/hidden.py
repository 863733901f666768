"""Forces that vary inside a step, but not where the step evaluates them.

Where laws of time break is known before the run (breakpoints.py). Where a law of coordinates, rates
and reactions breaks or has a peak is known only from the motion: a body that passes a narrow
contact within one step leaves nothing in its error estimate. Each accepted step is therefore looked
at: the quantities that an expression reads are polynomials between its ends, and interval
arithmetic bounds every part of the expression inside. A part that goes beyond its values at the
points that the method evaluates was not seen, and the step has to end there (docs/adr/0053).

Over a jump of a force the error estimate of a step may be a tenth of the error or less, whatever
the method: it compares sums over the same few points. Such a step may be only so long that the
jump changes the motion by less than the tolerance.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dynamics.evaluation.series import quantities
from ..dynamics.model.model import SLIP, SPIN, Model
from ..math.arrays import Array, IntArray
from ..math.compiled import inlined, lean, structure
from ..math.expressions import operations as op
from ..math.expressions.program import NO_SEED, Programs, evaluated
from ..math.expressions.ranges import bound_parts
from ..math.laws import Hermite
from .breakpoints import JUMPING, JUMPS, SPLIT, VARIES, programs_read
from .generic.base import Derivative
from .generic.norm import ErrorNorm

SHORTEST = 1e-6  # part of a step: what a shorter peak adds to the motion is below its rounding
MOST_CELLS = 20_000  # of the steps of one look; a law that needs more varies fast everywhere
WIDER = 4.0  # ranges of a step, by which the bounds without variation are wider
HALVES, LOOKS = 48, 4  # of a step, in which a break is located, and is looked for
BREAKING = JUMPING | {op.ABS, op.MINIMUM, op.MAXIMUM, op.SMOOTH, op.CURVE}
# BEND: largest error that a bend of a force causes in a step (of rk5, rk8, radau), as a factor of
# the length of the step and of the distance of the force from its continuation. BESIDE: distance
# of the points beside a bend, of the shorter part of the step. ROUNDING: of a force.
BEND, BESIDE, ROUNDING = 0.25, 0.02, 1e-12
UNSURE = 0.03  # tolerance, above which an error by a bend is looked at closer
CLOSER, PARTS = 2, 8  # times, and parts of an interval, in which a break is located
# Longest steps over a jump within which it comes back; attempts to pass it that are no motion.
AHEAD, OFTEN = 20.0, 30
CROWDED = 120.0  # steps in which so many stops at bends are no motion
SUMS = frozenset((op.ADD, op.SUBTRACT, op.NEGATE))


@structure
class Watched(NamedTuple):
    """An expression that reads the state, and which of its parts can hide something."""

    programs: Programs
    program: int
    stack: Array  # memory (math/expressions/program.py)
    timed: bool  # reads the time
    loads: IntArray  # (l,) quantities that it reads
    cubic: IntArray  # (l,) 1: the rate of a quantity follows it among all quantities
    curved: IntArray  # (n,) 1: a part is not linear in them
    breaking: IntArray  # (n,) 1: a part has branches
    points: Array  # (s,) parts of a step at which forces are evaluated
    span: Array  # (n, 2) least and largest value of each part so far
    quiet: Array  # (1 + l, 2) bounds of time and quantities within which no part varies much
    path: Array  # (1 + l, 4) coefficients of the powers of the part of a step
    box: Array  # (1 + l, 2) bounds over an interval
    bounds: Array  # (n, 2) of the parts
    breaks: IntArray  # (n,) of the parts: whether they may break, or their branches at a point
    branches: IntArray  # (n,) at the begin of an interval
    limits: Array  # (n, 2) of each part, beyond which it was not seen
    cells: Array  # (2, MOST_CELLS, 2) parts of a step, and those that they are divided into


class HiddenForces:
    """The expressions of a model that steps may pass without seeing how they vary.

    Parameters
    ----------
    model : a mechanism
    points : parts of a step, 0 and 1 among them, at which the method evaluates forces
    """

    def __init__(self, model: Model, points: tuple[float, ...]) -> None:
        self._model = model
        at, cells = np.array(points), np.zeros((2, MOST_CELLS, 2))
        found = (
            watched_expression(model, p, at, cells)
            for p in np.unique(programs_read(model)).tolist()
        )
        self._watched = [each for each in found if each is not None]

        self._breaking = [each for each in self._watched if each.breaking.any()]
        self._gain: dict[int, float] = {}  # of errors by bends of expressions, the last one found
        self._bends: dict[int, deque[float]] = {}  # last stops at bends [s]
        self._resting: set[int] = set()  # expressions whose bends may be passed from now on
        self._last: dict[int, tuple[float, int]] = {}  # last jump [s], attempts
        self.chattering: dict[int, float] = {}  # expressions, and since when [s]

    def __bool__(self) -> bool:
        return bool(self._watched)

    def stops(
        self, t: Array, y: Array, rate: Derivative, norm: ErrorNorm, over_bends: bool
    ) -> list[float]:
        """Return the instants [s] at which steps have to end, for the earliest cause; or none.

        One for a force that was not seen; two around a jump; a bend, and the end of its step.

        Parameters
        ----------
        t, y : (k + 1,), (k + 1, n) ends of k steps
        rate : f(t, y) -> (n,), valid up to the next call
        norm : of errors; 1 is just acceptable
        over_bends : steps may go over bends
        """
        found, values = np.inf, quantities(self._model, t, y)
        with np.errstate(all="ignore"):
            for each in self._watched:
                found = first_hidden(each, t, values, found)
            stops = [found] if np.isfinite(found) else []
            for each in list(self._breaking):
                i, part, jump, bend = first_break(each, t, values, 0, 0.0)
                passes = over_bends or each.program in self._resting
                path, begin = None, 0.0  # of the step that was looked at last
                while i >= 0 and t[i] + part * (t[i + 1] - t[i]) < found:
                    h = float(t[i + 1] - t[i])
                    gain = self._gain.get(each.program, np.inf)
                    if jump > 0.0 or (BEND * h * gain * bend > UNSURE and not passes):
                        if path is None or path.t_old != t[i]:
                            begin = float(t[i])
                            path = _path(t[i : i + 2], y[i : i + 2], rate)
                        more, begin = self._about(each, path, begin, rate, norm)
                        if more and more[0] < found and (jump > 0.0 or not over_bends):
                            found, stops = more[0], more
                            break
                    i, part, jump, bend = first_break(each, t, values, i, part)
        return stops

    def _about(
        self, each: Watched, path: Hermite, begin: float, rate: Derivative, norm: ErrorNorm
    ) -> tuple[list[float], float]:
        """Return stops about the first break along a step from `begin` [s], and where it is.

        No stops if the step is short enough: wherever a jump is, its error is at most that of the
        jump over the whole step; that of a bend has `BEND`.
        """
        low, high, end = begin, path.t_old + path.h, path.t_old + path.h
        for _ in range(CLOSER):
            t = np.linspace(low, high, PARTS + 1)
            i, part, jump, _ = first_break(each, t, quantities(self._model, t, path(t)), 0, 0.0)
            if i < 0:
                return [], end
            low, high = float(t[i]), float(t[i + 1])
        at = low + part * (high - low)
        weight = norm.weight(path.y_0, path.y_1)
        close = 1e3 * np.spacing(abs(at))
        if jump > 0.0:
            most = max(1.0 / max(norm((path.f_1 - path.f_0) * weight), 1e-300), close)
            if path.h > most and not self._chatters(each, at):
                return [max(at - 0.4 * most, path.t_old), at + 0.4 * most], at
            later = np.array([path.t_old, end + AHEAD * most])
            onwards = np.stack([path.y_0, path.y_1 + AHEAD * most * path.f_1])
            self._pass(each, later, onwards)
            return [], at
        side = min(at - path.t_old, end - at)
        if side < 2.0 * close:
            return [], at
        near = at + side * BESIDE * np.arange(-2.0, 3.0)
        states = path(near)
        F = self._values(each, near, states)
        slopes = 0.5 * abs(4.0 * (F[3] + F[1]) - F[4] - F[0] - 6.0 * F[2]) / BESIDE
        curves = 0.5 * abs(F[4] - 2.0 * F[3] + 2.0 * F[1] - F[0]) / BESIDE**2
        turn = abs(F[3] - 2.0 * F[2] + F[1])
        if not turn > ROUNDING * np.abs(F).max():
            return [], at
        rates = [rate(float(near[k]), states[k]).copy() for k in (1, 2, 3)]
        weight = norm.weight(path.y_0, path.y_0)  # the end may be far off
        gain = norm((rates[0] - 2.0 * rates[1] + rates[2]) * weight) / turn
        self._gain[each.program] = gain
        if not BEND * path.h * gain * (slopes + curves) > 1.0:
            return [], at
        # A bend in nearly every step: a state rests on it, and stops cost more than they help.
        ends = self._bends.setdefault(each.program, deque([-np.inf] * OFTEN, OFTEN))
        ends.append(at)
        if at - ends[0] < CROWDED * path.h:
            self._resting.add(each.program)
            return [], at
        # The step in two, as the next one could be so long that stages of no weight throw the state
        # out of a contact. Surely before what turns out to be a jump.
        return [at - close, end], at

    def _values(self, each: Watched, t: Array, y: Array) -> Array:
        """Return an expression at times t (k,) and states y (k, n)."""
        return np.array(
            [
                evaluated(
                    each.programs,
                    each.program,
                    at,
                    row,
                    NO_SEED,
                    NO_SEED,
                    self._model.quantities.stack,
                )[0]
                for at, row in zip(t.tolist(), quantities(self._model, t, y), strict=True)
            ]
        )

    def _chatters(self, watched: Watched, at: float) -> bool:
        """Count an attempt to step up to a jump at time `at`; tell whether it is one too many."""
        p = watched.program
        last, count = self._last.get(p, (-np.inf, 0))
        self._last[p] = last, count + 1
        if count == OFTEN:
            self.chattering[p] = at
            self._breaking = [each for each in self._breaking if each.program != p]
        return count == OFTEN

    def _pass(self, watched: Watched, t: Array, y: Array) -> None:
        """Note a step over a jump, which is behind the motion if the motion does not come back.

        If it does, both forces push towards the jump and hold the state there. t, y : (2,), (2, n)
        before the jump, and a little later on the straight line on which the state leaves it.
        """
        last, count = self._last.get(watched.program, (-np.inf, 0))
        if t[0] > last:  # not taken again
            values = quantities(self._model, t, y)
            behind = first_break(watched, t, values, 0, 0.0)[2] > 0.0
            self._last[watched.program] = float(t[0]), 0 if behind else count
            if not behind:
                self._chatters(watched, float(t[0]))


def watched_expression(model: Model, p: int, points: Array, cells: Array) -> Watched | None:
    """Return an expression that reads the state and is not linear in it; else None."""
    programs, n = model.quantities.programs, len(model.quantities.kind)
    own = slice(int(programs.start[p]), int(programs.start[p + 1]))
    codes, arguments = programs.code[own], programs.argument[own]
    loads = np.unique(arguments[codes == op.LOAD].astype(np.int64))
    curved = _curved(codes)
    if not loads.size or not curved.any():
        return None
    cubic = (loads < 2 * n) & (loads % 2 == 0)
    cubic[cubic] = ~np.isin(model.quantities.kind[loads[cubic] // 2], (SPIN, SLIP))
    nothing = np.array([np.inf, -np.inf])
    parts, read = len(curved), 1 + len(loads)
    return Watched(
        programs,
        p,
        model.quantities.stack,
        bool((codes == op.TIME).any()),
        loads,
        cubic.astype(np.int64),
        curved.astype(np.int64),
        np.isin(codes[~np.isin(codes, list(op.PUSHES))], list(BREAKING)).astype(np.int64),
        points,
        np.tile(nothing, (parts, 1)),
        np.tile(nothing, (read, 1)),
        np.zeros((read, 4)),
        np.zeros((read, 2)),
        np.zeros((parts, 2)),
        np.zeros(parts, dtype=np.int64),
        np.zeros(parts, dtype=np.int64),
        np.zeros((parts, 2)),
        cells,
    )


def _curved(codes: IntArray) -> NDArray[np.bool_]:
    """Tell which parts of an expression are not linear in what it reads."""
    constant, linear, curved = 0, 1, 2
    stack: list[int] = []
    found = []
    for code in codes.tolist():
        if code in op.PUSHES:
            stack.append(constant if code == op.CONSTANT else linear)
            continue
        count = 3 if code == op.SELECT else 2 if code in op.BINARY else 1
        given, stack = stack[-count:], stack[:-count]
        scaled = (code == op.MULTIPLY and min(given) == constant) or (
            code == op.DIVIDE and given[1] == constant
        )
        kept = code in SUMS or scaled or max(given) == constant
        stack.append(max(given) if kept else curved)
        found.append(stack[-1] == curved)
    return np.array(found, dtype=bool)


@lean
def first_hidden(watched: Watched, t: Array, values: Array, before: float) -> float:
    """Return the earliest instant [s] at which an expression was not seen, or `before`.

    Parameters
    ----------
    t, values : (k + 1,), (k + 1, m) ends of k steps and all quantities there
    before : instant [s] from which on nothing is looked for
    """
    for i in range(t.shape[0] - 1):
        if t[i] >= before:
            break
        _set_path(watched, t, values, i)
        _set_box(watched, 0.0, 1.0)
        if _is_quiet(watched):
            continue
        if _varies(watched, True):
            found = _unseen(watched, before, watched.cells.shape[1] // (t.shape[0] - 1))
            if found < before:
                return found
        else:
            _widen(watched)
    return before


@lean
def first_break(
    watched: Watched, t: Array, values: Array, first: int, begin: float
) -> tuple[int, float, float, float]:
    """Return where an expression next gets onto another branch, behind part `begin` of a step.

    Parameters
    ----------
    t, values : as of `first_hidden`
    first : the step

    Returns
    -------
    The step, -1 if there is none, and the part of it; the jump of the expression there, 0 where it
    is continuous; its bend: how far it gets from its continuation over the shorter side of the
    step, by differences.
    """
    last = watched.bounds.shape[0] - 1  # the whole expression
    for i in range(first, t.shape[0] - 1):
        _set_path(watched, t, values, i)
        if i > first:
            begin = 0.0
        _set_box(watched, begin, 1.0)
        _bound(watched)
        may = False
        for k in range(last + 1):
            may = may or (watched.breaking[k] > 0 and watched.breaks[k] > 0)
        if not may:
            continue
        size = _value(watched, begin)
        for k in range(last + 1):
            watched.branches[k] = watched.breaks[k]
        for n in range(LOOKS):
            high = begin + (1.0 - begin) * (n + 1.0) / LOOKS
            if not _has_left(watched, high):
                continue
            low = begin + (1.0 - begin) * n / LOOKS
            for _ in range(HALVES):
                middle = 0.5 * (low + high)
                if _has_left(watched, middle):
                    high = middle
                else:
                    low = middle
            before, behind = _value(watched, low), _value(watched, high)
            size = max(max(abs(size), abs(behind)), watched.span[last, 1] - watched.span[last, 0])
            if abs(behind - before) > JUMPS * size:
                return i, high, abs(behind - before), 0.0
            e = BESIDE * min(high, 1.0 - high)
            a, b = _value(watched, high - e), _value(watched, high - 2.0 * e)
            c, d = _value(watched, high + e), _value(watched, high + 2.0 * e)
            slopes = 0.5 * (4.0 * c - d - 6.0 * behind + 4.0 * a - b) / BESIDE
            curves = 0.5 * (d - 2.0 * c + 2.0 * a - b) / BESIDE**2
            return i, high, 0.0, abs(slopes) + abs(curves)
    return -1, 0.0, 0.0, 0.0


@lean
def _value(watched: Watched, at: float) -> float:
    """Return the expression at a part of the step; its parts are bounded."""
    _set_box(watched, at, at)
    _bound(watched)
    return float(watched.bounds[watched.bounds.shape[0] - 1, 0])


@lean
def _has_left(watched: Watched, at: float) -> bool:
    """Tell whether a part is at a part of a step on another branch than at the begin."""
    _value(watched, at)
    found = False
    for k in range(watched.breaking.shape[0]):
        found = found or (watched.breaking[k] > 0 and watched.breaks[k] != watched.branches[k])
    return found


def _path(t: Array, y: Array, rate: Derivative) -> Hermite:
    """Return the cubic by states and rates between the ends t (2,), y (2, n) of a step."""
    rates = [rate(float(t[k]), y[k]).copy() for k in range(2)]
    return Hermite(float(t[0]), float(t[1] - t[0]), y[0], rates[0], y[1], rates[1])


@inlined
def _set_path(watched: Watched, t: Array, values: Array, i: int) -> None:
    """Set the quantities along step i.

    A coordinate is the cubic by its values and rates, whose Bezier points bound it; other
    quantities are taken as linear.
    """
    h, path = t[i + 1] - t[i], watched.path
    path[0, 0], path[0, 1] = t[i], h
    for j in range(watched.loads.shape[0]):
        k = watched.loads[j]
        first, rise = values[i, k], values[i + 1, k] - values[i, k]
        begin = end = rise
        if watched.cubic[j] > 0:
            begin, end = h * values[i, k + 1], h * values[i + 1, k + 1]
        path[1 + j, 0], path[1 + j, 1] = first, begin
        path[1 + j, 2], path[1 + j, 3] = 3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise


@inlined
def _set_box(watched: Watched, a: float, b: float) -> None:
    """Set bounds of time and quantities in the part [a, b] of the step."""
    for j in range(watched.path.shape[0]):
        p, q = watched.path[j, 0], watched.path[j, 1]
        r, s = watched.path[j, 2], watched.path[j, 3]
        one, two = p + a * (q + a * (r + a * s)), p + b * (q + b * (r + b * s))
        third = (b - a) / 3.0
        near = one + third * (q + a * (2.0 * r + 3.0 * a * s))
        far = two - third * (q + b * (2.0 * r + 3.0 * b * s))
        watched.box[j, 0] = min(min(one, two), min(near, far))
        watched.box[j, 1] = max(max(one, two), max(near, far))


@inlined
def _is_quiet(watched: Watched) -> bool:
    """Tell whether the box lies in the one in which no part varies much."""
    inside = True
    for j in range(watched.box.shape[0]):
        inside = inside and watched.box[j, 0] >= watched.quiet[j, 0]
        inside = inside and watched.box[j, 1] <= watched.quiet[j, 1]
    return inside


@inlined
def _bound(watched: Watched) -> None:
    """Bound the parts in the box."""
    bound_parts(
        watched.programs,
        watched.program,
        watched.box,
        watched.loads,
        watched.stack,
        watched.bounds,
        watched.breaks,
    )


@lean
def _varies(watched: Watched, passed: bool) -> bool:
    """Tell whether a part may vary in the box by more than a share of its range so far.

    `passed`: by a step, so that the range of a part that does not vary so much counts.
    """
    bounds, span, found = watched.bounds, watched.span, False
    _bound(watched)
    for k in range(bounds.shape[0]):
        if watched.curved[k] > 0:
            least, most = bounds[k, 0], bounds[k, 1]
            if not most - least <= VARIES * max(span[k, 1] - span[k, 0], 0.0):
                found = True
            elif passed:
                span[k, 0], span[k, 1] = min(span[k, 0], least), max(span[k, 1], most)
    return found


@inlined
def _widen(watched: Watched) -> None:
    """Take a wider box for the one in which no part varies much, where none does."""
    box, quiet = watched.box, watched.quiet
    for j in range(box.shape[0]):
        wide = WIDER * (box[j, 1] - box[j, 0])
        box[j, 0], box[j, 1] = box[j, 0] - wide, box[j, 1] + wide
    if not _varies(watched, False):
        for j in range(box.shape[0]):
            quiet[j, 0], quiet[j, 1] = box[j, 0], box[j, 1]
        if not watched.timed:
            quiet[0, 0], quiet[0, 1] = -np.inf, np.inf


@lean
def _unseen(watched: Watched, before: float, room: int) -> float:
    """Return the earliest instant [s] of the step at which a part is beyond what was seen of it.

    `before` [s] if there is none, or none that early; room : most cells at a time.
    """
    _set_limits(watched)
    path, cells, found = watched.path, watched.cells, before
    now, count = 0, 1
    cells[0, 0, 0], cells[0, 0, 1] = 0.0, 1.0
    while count > 0 and SPLIT * count <= room:
        more = 0
        for c in range(count):
            a, b = cells[now, c, 0], cells[now, c, 1]
            if path[0, 0] + a * path[0, 1] >= found or not b - a > SHORTEST:
                continue
            if not _is_beyond(watched, a, b):
                continue
            middle = 0.5 * (a + b)
            if _is_beyond(watched, middle, middle):
                found = min(found, path[0, 0] + middle * path[0, 1])
            for n in range(SPLIT):
                cells[1 - now, more, 0] = a + (b - a) * (n / SPLIT)
                cells[1 - now, more, 1] = a + (b - a) * ((n + 1) / SPLIT)
                more += 1
        now, count = 1 - now, more
    return found


@inlined
def _set_limits(watched: Watched) -> None:
    """Set the limits of each part in the step by its values at the points of the method."""
    bounds, span, limits = watched.bounds, watched.span, watched.limits
    limits[:, 0] = np.inf
    limits[:, 1] = -np.inf
    for n in range(watched.points.shape[0]):
        _set_box(watched, watched.points[n], watched.points[n])
        _bound(watched)
        for k in range(bounds.shape[0]):
            value = bounds[k, 0]
            limits[k, 0], limits[k, 1] = min(limits[k, 0], value), max(limits[k, 1], value)
            if abs(value) < np.inf:
                span[k, 0], span[k, 1] = min(span[k, 0], value), max(span[k, 1], value)
    for k in range(bounds.shape[0]):
        low, high = limits[k, 0], limits[k, 1]
        margin = max(VARIES * max(span[k, 1] - span[k, 0], 0.0), high - low)
        limits[k, 0], limits[k, 1] = low - margin, high + margin


@lean
def _is_beyond(watched: Watched, a: float, b: float) -> bool:
    """Tell whether a part may be beyond its limits in the part [a, b] of the step."""
    bounds, limits, found = watched.bounds, watched.limits, False
    _set_box(watched, a, b)
    _bound(watched)
    for k in range(bounds.shape[0]):
        if watched.curved[k] > 0:
            beyond = bounds[k, 0] < limits[k, 0] or bounds[k, 1] > limits[k, 1]
            found = found or beyond
    return found
