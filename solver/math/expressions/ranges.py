"""Ranges of expressions over intervals of the time: bounds that hold for every instant in them.

Interval arithmetic on the programs of program.py, for many intervals at once. A bound may be too
wide, never too narrow, so that no pulse and no comparison that changes is missed.
"""

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from . import operations as op
from .program import Programs

PLACES = 5  # of a piece of a curve at which its values are looked at
INCREASING: dict[int, Callable[[Array], Array]] = {
    op.ARCSIN: np.arcsin,
    op.ARCTAN: np.arctan,
    op.SINH: np.sinh,
    op.TANH: np.tanh,
    op.EXP: np.exp,
    op.LOG: np.log,
    op.SQRT: lambda u: np.sqrt(np.maximum(u, 0.0)),
    op.SIGN: np.sign,
    op.FLOOR: np.floor,
    op.SMOOTH: lambda u: (s := np.clip(u, 0.0, 1.0)) ** 3 * (10.0 + s * (6.0 * s - 15.0)),
}
COMPARISONS = frozenset((op.LESS, op.LESS_EQUAL))
LOGICAL = frozenset((*COMPARISONS, op.AND, op.OR, op.NOT))
Range = tuple[Array, Array]
NO_LOADS: Mapping[int, Range] = MappingProxyType({})


class Part(NamedTuple):
    """A part of an expression over k intervals."""

    code: int
    low: Array  # (k,) bounds of its value
    high: Array
    breaks: NDArray[np.bool_] | None  # (k,) whether it may break inside; None: it is smooth


def curve_ranges(times: Array, coefficients: Array, low: Array, high: Array) -> Range:
    """Return bounds of a piecewise polynomial over intervals of its argument, (k,) each."""
    first = np.maximum(np.searchsorted(times, low, "right") - 1, 0)
    last = np.maximum(np.searchsorted(times, high, "right") - 1, 0)
    seen = [
        _values(times, coefficients, k, u)
        for k, u in ((first, low), (last, high), (first, 0.5 * (low + high)))
    ]
    seen[2] = np.where(first == last, seen[2], seen[0])
    least, most = np.minimum.reduce(seen), np.maximum.reduce(seen)
    many = np.flatnonzero(last > first)
    if many.size:
        # pieces first to last - 1 as a whole, with a place behind them for `reduceat`
        begin, end = int(first[many].min()), int(last[many].max())
        pieces, length = np.arange(begin, end), np.diff(times[begin : end + 1])
        lows, highs = np.full(end - begin + 1, np.inf), np.full(end - begin + 1, -np.inf)
        for place in np.linspace(0.0, 1.0, PLACES):
            v = _values(times, coefficients, pieces, times[begin:end] + place * length)
            np.minimum(lows[:-1], v, out=lows[:-1])
            np.maximum(highs[:-1], v, out=highs[:-1])
        at = np.column_stack([first[many], last[many]]).ravel() - begin
        least[many] = np.minimum(least[many], np.minimum.reduceat(lows, at)[::2])
        most[many] = np.maximum(most[many], np.maximum.reduceat(highs, at)[::2])
    return least, most


def _values(times: Array, coefficients: Array, k: NDArray[np.int64], u: Array) -> Array:
    s, found = u - times[k], np.zeros(len(k))
    for i in range(coefficients.shape[1] - 1, -1, -1):
        found = found * s + coefficients[k, i]
    return found


def parts(
    programs: Programs,
    p: int,
    low: Array,
    high: Array,
    loads: Mapping[int, Range] = NO_LOADS,
) -> Iterator[Part]:
    """Yield the parts of an expression whose ranges are known, over [low, high] (k,) [s].

    loads : ranges (k,) of quantities by their numbers; others are not known
    """
    if not len(low):
        return
    stack: list[Range | None] = []
    breaks: NDArray[np.bool_] | None
    with np.errstate(all="ignore"):
        for i in range(int(programs.start[p]), int(programs.start[p + 1])):
            code, argument = int(programs.code[i]), float(programs.argument[i])
            if code == op.CONSTANT:
                number = np.array([argument])  # the same in every interval
                stack.append((number, number))
                continue
            if code in op.PUSHES:
                stack.append((low, high) if code == op.TIME else loads.get(int(argument)))
                continue
            count = 3 if code == op.SELECT else 2 if code in op.BINARY else 1
            given, stack = stack[-count:], stack[:-count]
            known = [each for each in given if each is not None]
            if len(known) < count:
                stack.append(None)
                continue
            if code == op.CURVE:
                found, breaks = _curve(programs, int(argument), *known[0])
            else:
                found, breaks = _range(code, known), _breaks(code, known)
            if np.isnan(found[0] + found[1]).any():  # also of both infinities
                wrong = np.isnan(found[0]) | np.isnan(found[1])
                found = np.where(wrong, -np.inf, found[0]), np.where(wrong, np.inf, found[1])
            stack.append(found)
            yield Part(code, *found, breaks)


def _curve(programs: Programs, c: int, low: Array, high: Array) -> tuple[Range, NDArray[np.bool_]]:
    own = slice(int(programs.curve_start[c]), int(programs.curve_start[c + 1]))
    times = programs.curve_place[own]
    found = curve_ranges(times, programs.curve_coefficient[own], low, high)
    inside = np.searchsorted(times[1:], high, "right") > np.searchsorted(times[1:], low, "right")
    return found, inside


def _breaks(code: int, given: list[Range]) -> NDArray[np.bool_] | None:
    u, v = given[0]
    if code in (op.LESS, op.LESS_EQUAL, op.MINIMUM, op.MAXIMUM):
        w, x = given[1]
        # not where they are the same throughout, as of two numbers
        return (u <= x) & (w <= v) & ((u < v) | (w < x))
    if code in (op.ABS, op.SIGN):
        return (u <= 0.0) & (v >= 0.0) & (u < v)
    if code == op.FLOOR:
        return np.floor(u) < np.floor(v)
    if code == op.SMOOTH:
        return ((u <= 0.0) & (v > 0.0)) | ((u < 1.0) & (v >= 1.0))
    return None


def _range(code: int, given: list[Range]) -> Range:
    u, v = given[0]
    if code in INCREASING:
        return INCREASING[code](u), INCREASING[code](v)
    if code == op.NEGATE:
        return -v, -u
    if code == op.ARCCOS:
        return np.arccos(v), np.arccos(u)
    if code in (op.SIN, op.COS):
        shift = 0.0 if code == op.SIN else 0.5 * np.pi
        return _sine(u + shift, v + shift)
    if code == op.TAN:
        whole = np.floor(u / np.pi + 0.5) == np.floor(v / np.pi + 0.5)
        return np.where(whole, np.tan(u), -np.inf), np.where(whole, np.tan(v), np.inf)
    if code == op.ABS:
        return _size(u, v)
    if code == op.COSH:
        u, v = _size(u, v)
        return np.cosh(u), np.cosh(v)
    if code == op.SELECT:
        yes, no = (u > 0.0) | (v < 0.0), (u == 0.0) & (v == 0.0)
        (a, b), (c, d) = given[1:]
        low = np.where(yes, a, np.where(no, c, np.minimum(a, c)))
        return low, np.where(yes, b, np.where(no, d, np.maximum(b, d)))
    if code in LOGICAL:
        return _logical(code, given)
    w, x = given[1]
    if code == op.ADD:
        return u + w, v + x
    if code == op.SUBTRACT:
        return u - x, v - w
    if code == op.MINIMUM:
        return np.minimum(u, w), np.minimum(v, x)
    if code == op.MAXIMUM:
        return np.maximum(u, w), np.maximum(v, x)
    if code == op.ARCTAN2:
        low, high = _corners(np.arctan2, given)
        cut = (w <= 0.0) & (u <= 0.0) & (v >= 0.0) & ((u < v) | (w < x))
        return np.where(cut, -np.pi, low), np.where(cut, np.pi, high)
    if code == op.POWER:
        return _power(u, v, w, x)
    if code == op.DIVIDE:
        low, high = _corners(np.divide, given)
        pole = (w <= 0.0) & (x >= 0.0)
        return np.where(pole, -np.inf, low), np.where(pole, np.inf, high)
    return _corners(np.multiply, given)


def _corners(function: np.ufunc, given: list[Range]) -> Range:
    (u, v), (w, x) = given
    a, b = function(u, w), function(v, w)
    low, high = np.minimum(a, b), np.maximum(a, b)
    if x is w:  # a number
        return low, high
    c, d = function(u, x), function(v, x)
    return np.minimum(low, np.minimum(c, d)), np.maximum(high, np.maximum(c, d))


def _size(u: Array, v: Array) -> Range:
    """Return bounds of the absolute value."""
    a, b = np.abs(u), np.abs(v)
    return np.where((u <= 0.0) & (v >= 0.0), 0.0, np.minimum(a, b)), np.maximum(a, b)


def _sine(u: Array, v: Array) -> Range:
    a, b, turn = np.sin(u), np.sin(v), 2.0 * np.pi
    top = np.floor((v - 0.5 * np.pi) / turn) > np.floor((u - 0.5 * np.pi) / turn)
    bottom = np.floor((v + 0.5 * np.pi) / turn) > np.floor((u + 0.5 * np.pi) / turn)
    return np.where(bottom, -1.0, np.minimum(a, b)), np.where(top, 1.0, np.maximum(a, b))


def _power(u: Array, v: Array, w: Array, x: Array) -> Range:
    n = float(w[0])
    if not (np.all(w == n) and np.all(x == n) and n.is_integer()):
        return _corners(np.power, [(u, v), (w, x)])  # nan of a negative number
    even = n % 2.0 == 0.0
    if even:
        u, v = _size(u, v)
    a, b = u ** abs(n), v ** abs(n)
    if n >= 0.0:
        return a, b
    pole = (a <= 0.0) & (b >= 0.0)
    return np.where(pole & (not even), -np.inf, 1.0 / b), np.where(pole, np.inf, 1.0 / a)


def _logical(code: int, given: list[Range]) -> Range:
    u, v = given[0]
    if code in COMPARISONS:
        w, x = given[1]
        if code == op.LESS:
            return (v < w).astype(float), (u < x).astype(float)
        return (v <= w).astype(float), (u <= x).astype(float)
    surely, possibly = (u > 0.0) | (v < 0.0), (u != 0.0) | (v != 0.0)
    if code == op.NOT:
        return (~possibly).astype(float), (~surely).astype(float)
    w, x = given[1]
    also, perhaps = (w > 0.0) | (x < 0.0), (w != 0.0) | (x != 0.0)
    if code == op.AND:
        return (surely & also).astype(float), (possibly & perhaps).astype(float)
    return (surely | also).astype(float), (possibly | perhaps).astype(float)
