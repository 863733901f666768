"""Ranges of expressions over intervals of what they read, and where they may break.

Interval arithmetic on the programs of program.py. A bound may be too wide, never too narrow, so
that no pulse and no comparison that changes is missed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, IntArray
from ..compiled import inlined, lean
from ..laws import N_COEFFICIENT
from . import operations as op
from .operations import Programs
from .program import unary

# Arguments of tanh and atan at which they bend, for a step that is long beside the rise: where it
# begins, and where it is steep, as a step of rk5 from one flat side to the steep part was off by
# 30 tolerances.
FLAT, STEEP = 4.0, 1.0
PLACES = 5  # of a piece of a curve at which its values are looked at


class TermRange(NamedTuple):
    """A part of an expression over k intervals."""

    code: int
    low: Array  # (k,) bounds of its value
    high: Array
    breaks: NDArray[np.bool_]  # (k,) whether it may break inside


def parts(programs: Programs, p: int, low: Array, high: Array, stack: Array) -> list[TermRange]:
    """Return the parts of an expression that read the time alone, over [low, high] (k,) [s].

    Parameters
    ----------
    programs : expressions as arrays
    p : number of the expression
    low : begins of the intervals (k,) [s]
    high : their ends (k,) [s]
    stack : memory of the evaluation (program.py)
    """
    code = programs.code[programs.start[p] : programs.start[p + 1]]
    code = code[code > op.LOAD]
    bounds = np.zeros((len(low), len(code), 2))
    breaks = np.zeros((len(low), len(code)), dtype=np.int64)
    box, none = np.zeros((1, 2)), np.zeros(0, dtype=np.int64)
    with np.errstate(all="ignore"):
        _over_intervals(programs, p, low, high, box, none, stack, bounds, breaks)
    return [
        TermRange(int(code[j]), bounds[:, j, 0], bounds[:, j, 1], breaks[:, j] > 0)
        for j in range(len(code))
        if len(low) and not np.isnan(bounds[0, j, 0])
    ]


@lean
def _over_intervals(
    programs: Programs,
    p: int,
    low: Array,
    high: Array,
    box: Array,
    none: IntArray,
    stack: Array,
    bounds: Array,
    breaks: IntArray,
) -> None:
    for k in range(low.shape[0]):
        box[0, 0], box[0, 1] = low[k], high[k]
        bound_parts(programs, p, box, none, stack, bounds[k], breaks[k])


def curve_ranges(times: Array, coefficients: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return bounds of a piecewise polynomial over intervals of its argument, (k,) each.

    Parameters
    ----------
    times : begins of the pieces (n_piece,)
    coefficients : polynomials of the pieces (n_piece, N_COEFFICIENT)
    low : begins of the intervals (k,)
    high : their ends (k,)
    """
    bounds = np.zeros((len(low), 2))
    _over_curve(times, coefficients, low, high, bounds)
    return bounds[:, 0], bounds[:, 1]


@lean
def _over_curve(times: Array, coefficients: Array, low: Array, high: Array, bounds: Array) -> None:
    for k in range(low.shape[0]):
        bounds[k, 0], bounds[k, 1], _ = _of_curve(
            times, coefficients, 0, times.shape[0], low[k], high[k]
        )


@lean
def bound_parts(
    programs: Programs,
    p: int,
    box: Array,
    loads: IntArray,
    stack: Array,
    bounds: Array,
    breaks: IntArray,
) -> None:
    """Bound the n operations of an expression in their order, and return whether they break.

    Parameters
    ----------
    p : number of the expression
    box : (1 + l, 2) bounds of the time [s] and of the quantities `loads` (l,)
    stack : memory (program.py)
    bounds, breaks : (n, 2), (n,); filled: nan for a part that reads another quantity; 1 for one
        that may break, or, where `box` is a point, the branch on which it is
    """
    k, part, point = -1, 0, True
    for j in range(box.shape[0]):
        point = point and box[j, 0] == box[j, 1]
    for i in range(programs.start[p], programs.start[p + 1]):
        code = programs.code[i]
        if code <= op.LOAD:
            k += 1
            _push(code, programs.argument[i], box, loads, stack, k)
            continue
        may, branch = False, 0
        if code == op.SELECT:
            k -= 2
            low, high = _of_choice(stack, k)
        elif code >= op.NEGATE:
            u, v = stack[k, 0], stack[k, 1]
            low, high = _of_one(code, u, v)
            may = _breaks(code, u, v)
            branch = _branch(code, u) if point else 0
        elif code == op.CURVE:
            curve = int(programs.argument[i])
            low, high, may = _of_curve(
                programs.curve_place,
                programs.curve_coefficient,
                programs.curve_start[curve],
                programs.curve_start[curve + 1],
                stack[k, 0],
                stack[k, 1],
            )
            if point:
                begin, end = programs.curve_start[curve], programs.curve_start[curve + 1]
                branch = _piece(programs.curve_place, begin, end, stack[k, 0])
        else:
            k -= 1
            u, v, w, x = stack[k, 0], stack[k, 1], stack[k + 1, 0], stack[k + 1, 1]
            low, high = _of_two(code, u, v, w, x)
            if u != u or w != w:
                low = high = np.nan
            if code in (op.LESS, op.LESS_EQUAL, op.MINIMUM, op.MAXIMUM):
                # not where they are the same throughout, as of two numbers
                may = u <= x and w <= v and (u < v or w < x)
                if point:  # that of the value: where both are the same it has not jumped yet
                    branch = int(u <= w if code == op.LESS_EQUAL else u < w)
            elif code == op.ARCTAN2 and 0.0 < w == x:  # atan of a quotient
                may = _breaks(op.ARCTAN, u / w, v / w)
                if point:
                    branch = _rise(u / w)
        stack[k, 0], stack[k, 1] = bounds[part, 0], bounds[part, 1] = low, high
        breaks[part] = 1 if may else branch
        part += 1


@inlined
def _push(code: int, argument: float, box: Array, loads: IntArray, stack: Array, k: int) -> None:
    if code == op.CONSTANT:
        stack[k, 0] = stack[k, 1] = argument
    elif code == op.TIME:
        stack[k, 0], stack[k, 1] = box[0, 0], box[0, 1]
    else:
        stack[k, 0] = stack[k, 1] = np.nan
        for j in range(loads.shape[0]):
            if loads[j] == argument:
                stack[k, 0], stack[k, 1] = box[1 + j, 0], box[1 + j, 1]


@lean
def _of_curve(
    times: Array, coefficients: Array, begin: int, end: int, low: float, high: float
) -> tuple[float, float, bool]:
    """Return bounds of the pieces begin to end of curves over an interval, and if it has a knot."""
    if low != low:
        return low, low, False
    first, last = _piece(times, begin, end, low), _piece(times, begin, end, high)
    least, most, total = np.inf, -np.inf, 0.0
    for k in range(first, last + 1):
        near = low if k == first else times[k]
        far = high if k == last else times[k + 1]
        for n in range(PLACES):
            s = near + n / (PLACES - 1.0) * (far - near) - times[k]
            value = 0.0
            for i in range(N_COEFFICIENT - 1, -1, -1):
                value = value * s + coefficients[k, i]
            least, most, total = min(least, value), max(most, value), total + value
    if total != total:
        least, most = -np.inf, np.inf
    return least, most, last > first


@inlined
def _piece(times: Array, begin: int, end: int, t: float) -> int:
    """Return the piece in which t lies, the first one before its beginning."""
    while begin + 1 < end:
        middle = (begin + end) // 2
        if t >= times[middle]:
            begin = middle
        else:
            end = middle
    return begin


@inlined
def _breaks(code: int, u: float, v: float) -> bool:
    """Return whether a function of one argument may break in [u, v]."""
    if code in (op.ABS, op.SIGN):
        return u <= 0.0 and v >= 0.0 and u < v
    if code == op.FLOOR:
        return bool(np.floor(u) < np.floor(v))
    if code in (op.TANH, op.ARCTAN):
        return _rise(u) != _rise(v)
    return code == op.SMOOTH and ((u <= 0.0 and v > 0.0) or (u < 1.0 and v >= 1.0))


@inlined
def _rise(u: float) -> int:
    """Return the part of tanh or atan in which u is."""
    return int(u >= -FLAT) + int(u >= -STEEP) + int(u >= STEEP) + int(u >= FLAT)


@inlined
def _branch(code: int, u: float) -> int:
    """Return the branch on which a function of one argument is at u."""
    if code in (op.ABS, op.SIGN):
        return 2 if u > 0.0 else 1 if u == 0.0 else 0
    if code == op.FLOOR and abs(u) < 1e15:
        return int(np.floor(u))
    if code == op.SMOOTH:
        return 2 if u >= 1.0 else 1 if u > 0.0 else 0
    if code in (op.TANH, op.ARCTAN):
        return _rise(u)
    return 0


@lean
def _of_one(code: int, u: float, v: float) -> tuple[float, float]:
    """Return bounds of a function of one argument in [u, v]; nan of what is not known."""
    if u != u:
        return u, u
    if code == op.NEGATE:
        return -v, -u
    if code == op.NOT:
        surely, possibly = _truth(u, v)
        return 0.0 if possibly else 1.0, 0.0 if surely else 1.0
    if code in (op.SIN, op.COS):
        shift = 0.0 if code == op.SIN else 0.5 * np.pi
        return _sine(u + shift, v + shift)
    if code == op.TAN and np.floor(u / np.pi + 0.5) != np.floor(v / np.pi + 0.5):
        return -np.inf, np.inf
    if code in (op.ABS, op.COSH):
        u, v = _size(u, v)
    elif code == op.ARCCOS:
        u, v = v, u
    elif code == op.SQRT:
        u, v = max(u, 0.0), max(v, 0.0)
    low, _, _ = unary(code, u)
    high, _, _ = unary(code, v)
    return _known(low, high)


@inlined
def _known(low: float, high: float) -> tuple[float, float]:
    """Return bounds, infinite ones where they are not numbers."""
    if low != low or high != high:
        return -np.inf, np.inf
    return low, high


@inlined
def _size(u: float, v: float) -> tuple[float, float]:
    """Return bounds of the absolute value."""
    a, b = abs(u), abs(v)
    return 0.0 if u <= 0.0 and v >= 0.0 else min(a, b), max(a, b)


@inlined
def _sine(u: float, v: float) -> tuple[float, float]:
    a, b, turn = np.sin(u), np.sin(v), 2.0 * np.pi
    top = np.floor((v - 0.5 * np.pi) / turn) > np.floor((u - 0.5 * np.pi) / turn)
    bottom = np.floor((v + 0.5 * np.pi) / turn) > np.floor((u + 0.5 * np.pi) / turn)
    if a != a or b != b:
        return -1.0, 1.0
    return -1.0 if bottom else min(a, b), 1.0 if top else max(a, b)


@inlined
def _truth(u: float, v: float) -> tuple[bool, bool]:
    """Return whether a number in [u, v] is surely, and possibly, not zero."""
    return u > 0.0 or v < 0.0, u != 0.0 or v != 0.0


@inlined
def _of_choice(stack: Array, k: int) -> tuple[float, float]:
    """Return bounds of one of two values, by the condition in entry k."""
    surely, possibly = _truth(stack[k, 0], stack[k, 1])
    a, b, c, d = stack[k + 1, 0], stack[k + 1, 1], stack[k + 2, 0], stack[k + 2, 1]
    if stack[k, 0] != stack[k, 0] or a != a or c != c:
        return np.nan, np.nan
    if surely:
        return a, b
    if not possibly:
        return c, d
    return min(a, c), max(b, d)


@lean
def _of_two(code: int, u: float, v: float, w: float, x: float) -> tuple[float, float]:
    """Return bounds of a function of arguments in [u, v] and [w, x]."""
    if code == op.ADD:
        return _known(u + w, v + x)
    if code == op.SUBTRACT:
        return _known(u - x, v - w)
    if code == op.MULTIPLY:
        return _corners(u * w, u * x, v * w, v * x)
    if code == op.DIVIDE:
        if w <= 0.0 and x >= 0.0:
            return -np.inf, np.inf
        return _corners(u / w, u / x, v / w, v / x)
    if code == op.POWER:
        return _power(u, v, w, x)
    if code == op.MINIMUM:
        return min(u, w), min(v, x)
    if code == op.MAXIMUM:
        return max(u, w), max(v, x)
    if code == op.ARCTAN2:
        if w <= 0.0 and u <= 0.0 and v >= 0.0 and (u < v or w < x):
            return -np.pi, np.pi
        return _corners(np.arctan2(u, w), np.arctan2(u, x), np.arctan2(v, w), np.arctan2(v, x))
    if code == op.LESS:
        surely, possibly = v < w, u < x
    elif code == op.LESS_EQUAL:
        surely, possibly = v <= w, u <= x
    else:
        one, perhaps_one = _truth(u, v)
        two, perhaps_two = _truth(w, x)
        if code == op.AND:
            surely, possibly = one and two, perhaps_one and perhaps_two
        else:
            surely, possibly = one or two, perhaps_one or perhaps_two
    return 1.0 if surely else 0.0, 1.0 if possibly else 0.0


@inlined
def _corners(a: float, b: float, c: float, d: float) -> tuple[float, float]:
    total = a + b + c + d
    if total != total:
        return -np.inf, np.inf
    return min(min(a, b), min(c, d)), max(max(a, b), max(c, d))


@inlined
def _power(u: float, v: float, w: float, x: float) -> tuple[float, float]:
    if w != x or np.floor(w) != w:
        return _corners(u**w, u**x, v**w, v**x)  # nan of a negative number
    even = 2.0 * np.floor(0.5 * w) == w
    if even:
        u, v = _size(u, v)
    a, b = u ** abs(w), v ** abs(w)
    if w >= 0.0:
        return a, b
    pole = a <= 0.0 and b >= 0.0
    return -np.inf if pole and not even else 1.0 / b, np.inf if pole else 1.0 / a
