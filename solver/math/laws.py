"""Laws of time for drives, actuators and loads, and curves y(x) through points.

The step loop treats constant speed, polynomials, smooth steps and tables in the same way:
as pieces. Each piece is a polynomial of t - t_piece that is valid until the next begins. The last
piece has no end, and the first is also valid before its beginning.

Curves are laws of another argument that go on beyond both ends.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from .arrays import Array, IntArray
from .compiled import jit

Numbers = Sequence[float] | Array
Pieces = Literal["linear", "pchip", "spline"]
N_COEFFICIENT = 8  # a polynomial of degree 7
PLACES = 33  # of a piece at which its values are compared with those of its ends
AT_ONCE = 10_000  # pieces that are compared at once
SINE_PIECES = 32  # pieces of a sine ramp: acceleration accurate to 1e-11 of its mean


class Law(NamedTuple):
    """Pieces of one law: their beginnings (k,) [s] and coefficients (k, N_COEFFICIENT).

    `expression` (math/expressions/program.py) takes their place where there is one.
    """

    times: Array
    coefficients: Array
    expression: Any = None


def of_expression(expression: Any) -> Law:
    """The law that an expression of the time says."""
    return Law(np.zeros(1), np.zeros((1, N_COEFFICIENT)), expression)


@jit
def law_value(
    start: IntArray, times: Array, coefficients: Array, law: int, t: float
) -> tuple[float, float, float]:
    """Return value, first and second derivative of a law at t.

    `start` (n_law + 1,) are the first pieces of all laws, `times` (n_piece,) and `coefficients`
    (n_piece, N_COEFFICIENT) the pieces of all laws end to end.

    Parameters
    ----------
    start : first pieces of all laws (n_law + 1,)
    times : begins of all pieces (n_piece,) [s]
    coefficients : polynomials of all pieces (n_piece, N_COEFFICIENT)
    law : number of the law
    t : time [s], or the argument of a curve
    """
    k, end = start[law], start[law + 1]
    while k + 1 < end:
        middle = (k + end) // 2
        if t >= times[middle]:
            k = middle
        else:
            end = middle
    s = t - times[k]
    f, f_d, f_dd = 0.0, 0.0, 0.0
    for i in range(N_COEFFICIENT - 1, -1, -1):
        f_dd = f_dd * s + 2.0 * f_d
        f_d = f_d * s + f
        f = f * s + coefficients[k, i]
    return f, f_d, f_dd


def _pieces(times: Sequence[float], coefficients: Sequence[Sequence[float]]) -> Law:
    table = np.zeros((len(times), N_COEFFICIENT))
    for row, values in zip(table, coefficients, strict=True):
        row[: len(values)] = values
    return Law(np.array(times, dtype=float), table)


def polynomial(coefficients: Sequence[float]) -> Law:
    """The law c_0 + c_1 t + c_2 t^2 + ..., up to degree 7."""
    return _pieces([0.0], [coefficients])


def smooth_step(value: float, duration: float, start: float = 0.0) -> Law:
    """From 0 at `start` to `value` after `duration` [s]; speed and acceleration begin and end at 0.

    value (10 s^3 - 15 s^4 + 6 s^5) with s = (t - start) / duration.

    Parameters
    ----------
    value : value at the end, in the unit of the law
    duration : length of the rise [s]
    start : its begin [s]
    """
    s = 1.0 / duration
    rise = [0.0, 0.0, 0.0, 10.0 * value * s**3, -15.0 * value * s**4, 6.0 * value * s**5]
    return _pieces([start - duration, start, start + duration], [[0.0], rise, [value]])


def ramp(speed: float, duration: float, offset: float = 0.0, *, sine: bool = False) -> Law:
    """Start from rest at `offset` and reach a constant speed after `duration` [s] by a smooth step.

    With `sine` the acceleration is 1 - cos(2 pi t / duration) times its mean.

    Parameters
    ----------
    speed : rate of the law after the rise [unit/s]
    duration : length of the rise [s]
    offset : value at t = 0
    sine : whether the acceleration is a full wave of a cosine
    """
    s = 1.0 / duration
    rise = [offset, 0.0, 0.0, 0.0, 2.5 * speed * s**3, -3.0 * speed * s**4, speed * s**5]
    end = [offset + 0.5 * speed * duration, speed]
    if not sine:
        return _pieces([0.0, duration], [rise, end])
    times = np.linspace(0.0, duration, SINE_PIECES + 1)
    rises = _sine_rise(speed, times, offset)
    return _pieces(list(times), [*rises, end])


def _sine_rise(speed: float, times: Array, offset: float) -> list[list[float]]:
    """Angle in pieces: the acceleration in Chebyshev points, degree 5, integrated twice."""
    duration, length, k = float(times[-1]), float(times[1]), np.arange(6)[:, None]
    u = 0.5 - 0.5 * np.cos(np.pi * (k + 0.5) / 6)  # of a piece from 0 to 1
    acceleration = (
        speed / duration * (1.0 - np.cos(2 * np.pi * (times[:-1] + length * u) / duration))
    )
    rises = length * np.linalg.solve(u**k.T, acceleration) / (k + 1)
    rate = np.cumsum([0.0, *rises.sum(axis=0)])[:-1]
    turns = length * rises / (k + 2)
    angle = offset + np.cumsum([0.0, *(length * rate + turns.sum(axis=0))])[:-1]
    pieces = np.vstack([angle, length * rate, turns]) / length ** np.arange(N_COEFFICIENT)[:, None]
    return [list(map(float, piece)) for piece in pieces.T]


def table(times: Numbers, values: Numbers, interpolation: Pieces = "spline") -> Law:
    """Through points: straight lines, a monotone cubic (Fritsch and Carlson), or a cubic spline.

    The spline (not-a-knot) has two continuous derivatives and may leave the range of the values;
    the monotone cubic has one and does not. After the last time the last value is kept.

    Parameters
    ----------
    times : times of the points (k,) [s]
    values : values at these times (k,)
    interpolation : "linear", "pchip" (monotone) or "spline"

    Raises
    ------
    ValueError : fewer than two points, times not in ascending order, non-finite numbers.
    """
    t, f = checked_points(times, values)
    pieces = np.zeros((t.size, N_COEFFICIENT))
    if interpolation == "linear":
        pieces[:-1, 0], pieces[:-1, 1] = f[:-1], np.diff(f) / np.diff(t)
    else:
        from scipy.interpolate import CubicSpline, PchipInterpolator  # 0.1 s: only for tables

        made = (CubicSpline if interpolation == "spline" else PchipInterpolator)(t, f)
        pieces[:-1, :4] = made.c[::-1].T
    pieces[-1, 0] = f[-1]
    return Law(t.copy(), pieces)


def checked_points(times: Numbers, values: Numbers) -> tuple[Array, Array]:
    """Return the points of a table, (k,) each.

    Raises ValueError : fewer than two points, times not in ascending order, non-finite numbers.
    """
    t, f = np.asarray(times, dtype=float), np.asarray(values, dtype=float)
    if t.ndim != 1 or t.shape != f.shape or t.size < 2:
        raise ValueError(f"expected as many values as times, two at least, got {t.size}, {f.size}")
    for name, array in (("times", t), ("values", f)):
        bad = np.flatnonzero(~np.isfinite(array))
        if bad.size:
            raise ValueError(f"{name}[{bad[0]}] = {array[bad[0]]}: expected a finite number")
    if not np.all(np.diff(t) > 0.0):
        i = int(np.flatnonzero(np.diff(t) <= 0.0)[0]) + 1
        raise ValueError(
            f"times[{i}] = {t[i]:g}: expected more than {t[i - 1]:g}, times must ascend"
        )
    return t, f


def overshoot(law: Law, values: Numbers, first: int = 0) -> float:
    """Return how far a curve goes beyond the range of its points, over that range.

    Parameters
    ----------
    values : of the points, of which neighbours bound the pieces `first`, `first + 1`, ... of `law`
    """
    low, high = float(np.min(values)), float(np.max(values))
    if not low < high:
        return 0.0
    most, least, last = high, low, first + len(values) - 1
    for begin in range(first, last, AT_ONCE):
        end = min(begin + AT_ONCE, last)
        s = np.diff(law.times[begin : end + 1])[:, None] * np.linspace(0.0, 1.0, PLACES)
        value = np.zeros_like(s)
        for i in range(N_COEFFICIENT - 1, -1, -1):
            value = value * s + law.coefficients[begin:end, i, None]
        most, least = max(most, float(value.max())), min(least, float(value.min()))
    return float(max(most - high, low - least) / (high - low))


def lengths_along(points: Array) -> Array:
    """Return the length of the line through points (n, d) up to each of them, (n,), from 0 [m]."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


class Hermite:
    """The cubic through values and slopes at both ends of a step."""

    def __init__(
        self, t_old: float, h: float, y_0: Array, f_0: Array, y_1: Array, f_1: Array
    ) -> None:
        self.t_old, self.h, self.y_0, self.f_0, self.y_1, self.f_1 = t_old, h, y_0, f_0, y_1, f_1

    def __call__(self, t: Any) -> Array:
        """State at times t (...,), (..., n)."""
        x = ((np.asarray(t, dtype=float) - self.t_old) / self.h)[..., None]
        rise = x * x * (3 - 2 * x)
        bent = x * (1 - x) * self.h
        answer: Array = (
            (1 - rise) * self.y_0
            + rise * self.y_1
            + bent * (1 - x) * self.f_0
            - bent * x * self.f_1
        )
        return answer


class _Polynomial(ABC):
    """y_old + p(x) with x = (t - t_old) / h; the rows of `c` are the coefficients of p."""

    def __init__(self, t_old: float, h: float, y_old: Array, c: Array) -> None:
        self.t_old, self.h, self.y_old, self.c = t_old, h, y_old, c

    def __call__(self, t: Any) -> Array:
        x = ((np.asarray(t, dtype=float) - self.t_old) / self.h)[..., None]
        return self._change(x, np.zeros(x.shape[:-1] + self.y_old.shape)) + self.y_old

    @abstractmethod
    def _change(self, x: Array, y: Array) -> Array:
        """Value of p at x, from zeros y of the shape of the answer."""


class Nested(_Polynomial):
    """p = x (c0 + (1-x) (c1 + x (c2 + ...)))."""

    def _change(self, x: Array, y: Array) -> Array:
        for i in range(len(self.c) - 1, -1, -1):
            y = (y + self.c[i]) * (x if i % 2 == 0 else 1 - x)
        return y


class Powers(_Polynomial):
    """p = sum over j of c_j x^(j+1)."""

    def _change(self, x: Array, y: Array) -> Array:
        for c_j in self.c[::-1]:
            y = (y + c_j) * x
        return y


Interpolation = Literal["linear", "cubic", "pchip"]
Extrapolation = Literal["linear", "constant"]
KINDS: dict[str, Pieces] = {"cubic": "spline", "pchip": "pchip"}  # as laws name them


@dataclass(frozen=True)
class NamedCurve:
    """A curve that expressions call by its name; curves of one name and order are the same.

    order : of the derivative that it is of the curve of this name
    """

    name: str
    law: Law = field(compare=False)
    order: int = 0

    def derivative(self) -> "NamedCurve":
        """Return its derivative by its argument."""
        slopes = np.zeros_like(self.law.coefficients)
        slopes[:, :-1] = self.law.coefficients[:, 1:] * np.arange(1, N_COEFFICIENT)
        return NamedCurve(self.name, Law(self.law.times, slopes), self.order + 1)


def curve(x: Numbers, y: Numbers, *, smooth: bool = True) -> Law:
    """Return a natural cubic spline, or straight lines; straight on beyond both ends.

    Parameters
    ----------
    x : arguments of the points (k,)
    y : values there (k,)
    smooth : spline in place of straight lines

    Raises
    ------
    ValueError : fewer than two points, x not in ascending order, non-finite numbers.
    """
    return _through(x, y, "natural" if smooth and len(x) > 2 else "linear", "linear")


def curve_of_table(
    x: Numbers, y: Numbers, interpolation: Interpolation, beyond: Extrapolation
) -> Law:
    """Return straight lines, a cubic spline, or a monotone cubic (Fritsch and Carlson).

    The spline has the same cubic in its first two pieces, and in its last two (not-a-knot).

    Parameters
    ----------
    x : arguments of the points (k,)
    y : values there (k,)
    interpolation : course between the points
    beyond : straight on at both ends, or the value of the end

    Raises
    ------
    ValueError : fewer than two points, x not in ascending order, non-finite numbers.
    """
    return _through(x, y, interpolation, beyond)


def _through(
    x: Numbers,
    y: Numbers,
    interpolation: Interpolation | Literal["natural"],
    beyond: Extrapolation,
) -> Law:
    try:
        inner = table(x, y, KINDS.get(interpolation, "linear"))
    except ValueError as error:
        message = str(error).replace("times", "x").replace("values", "y")
        raise ValueError(message) from error
    if interpolation == "natural":
        from scipy.interpolate import CubicSpline  # 0.1 s: only for curves

        inner.coefficients[:-1, :4] = CubicSpline(x, y, bc_type="natural").c[::-1].T
    outer = np.zeros((2, N_COEFFICIENT))
    outer[:, 0] = y[0], y[-1]
    if beyond == "linear":
        outer[:, 1] = inner.coefficients[0, 1], _slope(inner, float(x[-1] - x[-2]))
    return Law(
        np.array([x[0], *inner.times]),
        np.concatenate([outer[:1], inner.coefficients[:-1], outer[1:]]),
    )


def _slope(law: Law, s: float) -> float:
    """Return the slope of the last piece but one at s; no power of s overflows."""
    slope = 0.0
    for i in range(N_COEFFICIENT - 1, 0, -1):
        slope = slope * s + i * float(law.coefficients[-2, i])
    return slope
