"""An expression of the state along the steps of a run: its ranges, and its breaks.

Between the ends of a step the quantities that an expression reads are polynomials. Interval
arithmetic bounds every part of the expression over any part of the step, and says where one may
get onto another branch (docs/adr/0053).
"""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dynamics.model.model import SLIP, SPIN, Model
from ..math.arrays import Array, IntArray, distinct, zeros_of
from ..math.compiled import inlined, lean, structure
from ..math.expressions import operations as op
from ..math.expressions.operations import Programs
from ..math.expressions.ranges import bound_parts
from .breakpoints import JUMPING, JUMPS, RISING, SPLIT, VARIES

SHORTEST = 1e-6  # part of a step: what a shorter peak adds to the motion is below its rounding
WIDER = 4.0  # ranges of a step, by which the bounds without variation are wider
HALVES, LOOKS = 48, 4  # of a step, in which a break is located, and is looked for
SAME = 1e-9  # part of a step, within which two breaks are one: x > 1 and max(x - 1, 0)
BREAKING = JUMPING | {op.ABS, op.MINIMUM, op.MAXIMUM, op.SMOOTH, op.CURVE} | RISING
# BEND: largest error that a bend of a force causes in a step (of rk5, rk8, radau), as a factor of
# the length of the step and of the distance of the force from its continuation. BESIDE: distance
# of the points beside a bend, of the shorter part of the step. ROUNDING: of a force.
BEND, BESIDE, ROUNDING = 0.25, 0.02, 1e-12
SUMS = frozenset((op.ADD, op.SUBTRACT, op.NEGATE))


@structure
class Watched(NamedTuple):
    """An expression that reads the state, and which of its parts can hide something."""

    programs: Programs
    program: int
    stack: Array  # memory (math/expressions/program.py)
    timed: bool  # reads the time
    rises: bool  # may rise from one value to another within little of what it reads
    loads: IntArray  # (l,) quantities that it reads
    slope: IntArray  # (l,) place of the rate of a quantity among all values; -1: not known
    mean: IntArray  # (l,) place of the coordinate of a rate; -1: none
    curved: IntArray  # (n,) 1: a part is not linear in them
    breaking: IntArray  # (n,) 1: a part has branches
    points: Array  # (s,) parts of a step at which forces are evaluated
    span: Array  # (n, 2) least and largest value of each part so far
    quiet: Array  # (1 + l, 2) bounds of time and quantities within which no part varies much
    path: Annotated[Array, "read, 4"]  # coefficients of the powers of the part of a step
    box: Annotated[Array, "read, 2"]  # bounds over an interval
    bounds: Annotated[Array, "parts, 2"]  # of the parts
    # of the parts: whether they may break, or their branches at a point
    breaks: Annotated[IntArray, "parts"]
    branches: Annotated[IntArray, "parts"]  # at the begin of an interval
    limits: Annotated[Array, "parts, 2"]  # of each part, beyond which it was not seen
    cells: Array  # (2, MOST_CELLS, 2) parts of a step, and those that they are divided into
    beside: Annotated[Array, "5"]  # values of the expression about a bend


def watched_expression(model: Model, p: int, points: Array, cells: Array) -> Watched | None:
    """Return an expression that reads the state and is not linear in it; else None.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    p : number of the expression
    points : parts of a step at which it is evaluated
    cells : memory of the parts of a step (2, MOST_CELLS, 2)
    """
    programs, n = model.quantities.programs, len(model.quantities.kind)
    own = slice(int(programs.start[p]), int(programs.start[p + 1]))
    codes, arguments = programs.code[own], programs.argument[own]
    loads = distinct(arguments[codes == op.LOAD].astype(np.int64))
    curved = _curved(codes)
    if not loads.size or not curved.any():
        return None
    cubic = loads < 2 * n
    cubic[cubic] = ~np.isin(model.quantities.kind[loads[cubic] // 2], (SPIN, SLIP))
    cubic, rates = cubic & (loads % 2 == 0), cubic & (loads % 2 == 1)
    # rates of states follow all quantities
    states, every = 2 * n + model.n_aux, 2 * n + model.n_aux + len(model.quantities.reaction_joint)
    of_states = np.where((loads >= 2 * n) & (loads < states), every + loads - 2 * n, -1)
    nothing, last = np.array([np.inf, -np.inf]), codes[~np.isin(codes, list(op.PUSHES))]
    return zeros_of(
        Watched,
        {"parts": len(curved), "read": 1 + len(loads)},
        programs=programs,
        program=p,
        stack=model.quantities.stack,
        timed=bool((codes == op.TIME).any()),
        rises=bool(np.isin(codes, list(RISING)).any()),
        loads=loads,
        slope=np.where(cubic, loads + 1, of_states),
        mean=np.where(rates, loads - 1, -1),
        curved=curved.astype(np.int64),
        breaking=np.isin(last, list(BREAKING)).astype(np.int64),
        points=points,
        span=np.tile(nothing, (len(curved), 1)),
        quiet=np.tile(nothing, (1 + len(loads), 1)),
        cells=cells,
    )


def _curved(codes: IntArray) -> NDArray[np.bool_]:
    """Return which parts of an expression are not linear in what it reads."""
    constant, linear, curved = 0, 1, 2
    stack: list[int] = []
    flags = []
    for code in codes.tolist():
        if code in op.PUSHES:
            stack.append(constant if code == op.CONSTANT else linear)
            continue
        count = op.operands(code)
        given, stack = stack[-count:], stack[:-count]
        scaled = (code == op.MULTIPLY and min(given) == constant) or (
            code == op.DIVIDE and given[1] == constant
        )
        kept = code in SUMS or scaled or max(given) == constant
        stack.append(max(given) if kept else curved)
        flags.append(stack[-1] == curved)
    return np.array(flags, dtype=bool)


@lean
def first_hidden(watched: Watched, t: Array, values: Array, before: float, sure: float) -> float:
    """Return the earliest instant [s] at which an expression was not seen, or `before`.

    Parameters
    ----------
    t, values : (k + 1,), (k + 1, m) ends of k steps and all quantities there
    before : instant [s] from which on nothing is looked for
    sure : change of a coordinate over a step above which its rate is no straight line
    """
    for i in range(t.shape[0] - 1):
        if t[i] >= before:
            break
        _set_path(watched, t, values, i)
        _curve_rates(watched, t, values, i, sure)
        _set_box(watched, 0.0, 1.0)
        if _is_quiet(watched):
            continue
        if _varies(watched, True):
            hidden = _unseen(watched, before, watched.cells.shape[1] // (t.shape[0] - 1))
            if hidden < before:
                return hidden
        else:
            _widen(watched)
    return before


@lean
def first_break(
    watched: Watched, t: Array, values: Array, first: int, begin: float, sure: float
) -> tuple[int, float, float, float, float]:
    """Return where an expression next gets onto another branch, behind part `begin` of a step.

    Parameters
    ----------
    t, values, sure : as of `first_hidden`
    first : the step

    Returns
    -------
    The step, -1 if there is none, and the part of it; the jump of the expression there, 0 where it
    is continuous; its bend, as of `bend`; its range over the step, beyond which no bend takes it.
    """
    last = watched.bounds.shape[0] - 1  # the whole expression
    for i in range(first, t.shape[0] - 1):
        _set_path(watched, t, values, i)
        _curve_rates(watched, t, values, i, sure)
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
            before, behind = _value(watched, low), _value(watched, min(high + SAME, 1.0))
            size = max(max(abs(size), abs(behind)), watched.span[last, 1] - watched.span[last, 0])
            jump = abs(behind - before)  # less what a steep part goes on by
            jump -= abs(_value(watched, min(high + 2.0 * SAME, 1.0)) - behind)
            jump = jump if jump > JUMPS * size else 0.0
            side = BESIDE * min(high, 1.0 - high)
            for m in range(5):
                watched.beside[m] = _value(watched, high + (m - 2.0) * side)
            _set_box(watched, 0.0, 1.0)
            _bound(watched)
            reach = watched.bounds[last, 1] - watched.bounds[last, 0]
            return i, high, jump, _departure(watched.beside), reach
    return -1, 0.0, 0.0, 0.0, 0.0


@lean
def bend(watched: Watched, t: Array, values: Array) -> tuple[float, float]:
    """Return how much an expression bends at the middle of five instants BESIDE of a side apart.

    Parameters
    ----------
    t, values : (5,), (5, m) instants [s] and all quantities there

    Returns
    -------
    A factor of the error of a step that does not see it: the length of the step and the change of
    the state's rate by a unit of the expression are the others. Second difference, 0 if rounding.
    """
    beside, size = watched.beside, 0.0
    for m in range(5):
        watched.box[0, :] = t[m]
        for j in range(watched.loads.shape[0]):
            watched.box[1 + j, :] = values[m, watched.loads[j]]
        _bound(watched)
        beside[m] = watched.bounds[watched.bounds.shape[0] - 1, 0]
        size = max(size, abs(beside[m]))
    turn = abs(beside[3] - 2.0 * beside[2] + beside[1])
    return _departure(beside), turn if turn > ROUNDING * size else 0.0


@inlined
def _departure(beside: Array) -> float:
    """Return BEND times the distance of a force from its continuation, by its five values."""
    a, b, c, d, e = beside[0], beside[1], beside[2], beside[3], beside[4]
    slopes = 0.5 * abs(4.0 * (d + b) - e - a - 6.0 * c) / BESIDE
    curves = 0.5 * abs(e - 2.0 * d + 2.0 * b - a) / BESIDE**2
    return float(BEND * (slopes + curves))


@lean
def _value(watched: Watched, at: float) -> float:
    """Return the expression at a part of the step; its parts are bounded."""
    _set_box(watched, at, at)
    _bound(watched)
    return float(watched.bounds[watched.bounds.shape[0] - 1, 0])


@lean
def _has_left(watched: Watched, at: float) -> bool:
    """Return whether a part is at a part of a step on another branch than at the begin."""
    _value(watched, at)
    left = False
    for k in range(watched.breaking.shape[0]):
        left = left or (watched.breaking[k] > 0 and watched.breaks[k] != watched.branches[k])
    return left


@inlined
def _set_path(watched: Watched, t: Array, values: Array, i: int) -> None:
    """Set the quantities along step i.

    A coordinate or a state is the cubic by its values and rates, whose Bezier points bound it;
    rates of coordinates are parabolas (`_curve_rates`), other quantities are taken as linear.
    """
    h, path = t[i + 1] - t[i], watched.path
    path[0, 0], path[0, 1] = t[i], h
    for j in range(watched.loads.shape[0]):
        k = watched.loads[j]
        first, rise = values[i, k], values[i + 1, k] - values[i, k]
        begin = end = rise
        r = watched.slope[j]
        if r >= 0:
            begin, end = h * values[i, r], h * values[i + 1, r]
        path[1 + j, 0], path[1 + j, 1] = first, begin
        path[1 + j, 2], path[1 + j, 3] = 3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise


@inlined
def _curve_rates(watched: Watched, t: Array, values: Array, i: int, sure: float) -> None:
    """Take rates as the parabolas by their ends and their means, from what coordinates change by.

    The mean over a short step has the error of the coordinate over its length. Where the change is
    that of a straight line but for `sure`, the line stays: a peak by rounding would be divided
    without end.
    """
    h, path = t[i + 1] - t[i], watched.path
    for j in range(watched.loads.shape[0]):
        k = watched.loads[j]
        if watched.mean[j] >= 0:
            rise = values[i + 1, watched.mean[j]] - values[i, watched.mean[j]]
            gap = rise - 0.5 * h * (values[i, k] + values[i + 1, k])
            if abs(gap) > sure:
                path[1 + j, 1] += 6.0 * gap / h
                path[1 + j, 2] -= 6.0 * gap / h


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
    """Return whether the box lies in the one in which no part varies much."""
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
    """Return whether a part may vary in the box by more than a share of its range so far.

    `passed`: by a step, so that the range of a part that does not vary so much counts.
    """
    bounds, span, varies = watched.bounds, watched.span, False
    _bound(watched)
    for k in range(bounds.shape[0]):
        if watched.curved[k] > 0:
            least, most = bounds[k, 0], bounds[k, 1]
            if not most - least <= VARIES * max(span[k, 1] - span[k, 0], 0.0):
                varies = True
            elif passed:
                span[k, 0], span[k, 1] = min(span[k, 0], least), max(span[k, 1], most)
    return varies


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
    path, cells, unseen = watched.path, watched.cells, before
    now, count = 0, 1
    cells[0, 0, 0], cells[0, 0, 1] = 0.0, 1.0
    while count > 0 and SPLIT * count <= room:
        more = 0
        for c in range(count):
            a, b = cells[now, c, 0], cells[now, c, 1]
            if path[0, 0] + a * path[0, 1] >= unseen or not b - a > SHORTEST:
                continue
            if not _is_beyond(watched, a, b):
                continue
            middle = 0.5 * (a + b)
            if _is_beyond(watched, middle, middle):
                unseen = min(unseen, path[0, 0] + middle * path[0, 1])
            for n in range(SPLIT):
                cells[1 - now, more, 0] = a + (b - a) * (n / SPLIT)
                cells[1 - now, more, 1] = a + (b - a) * ((n + 1) / SPLIT)
                more += 1
        now, count = 1 - now, more
    return unseen


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
    """Return whether a part may be beyond its limits in the part [a, b] of the step."""
    bounds, limits, outside = watched.bounds, watched.limits, False
    _set_box(watched, a, b)
    _bound(watched)
    for k in range(bounds.shape[0]):
        if watched.curved[k] > 0:
            beyond = bounds[k, 0] < limits[k, 0] or bounds[k, 1] > limits[k, 1]
            outside = outside or beyond
    return outside
