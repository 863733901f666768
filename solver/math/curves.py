"""Curves y(x) through points: polylines, cubics between two times, piecewise polynomials."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from . import laws
from .arrays import Array
from .laws import N_COEFFICIENT, Law, Numbers, table


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


Interpolation = Literal["linear", "cubic", "pchip"]
Extrapolation = Literal["linear", "constant"]
KINDS: dict[str, laws.Interpolation] = {"cubic": "spline", "pchip": "pchip"}  # as laws name them


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

    Raises ValueError : fewer than two points, x not in ascending order, non-finite numbers.
    """
    return _through(x, y, "natural" if smooth and len(x) > 2 else "linear", "linear")


def curve_of_table(
    x: Numbers, y: Numbers, interpolation: Interpolation, beyond: Extrapolation
) -> Law:
    """Return straight lines, a cubic spline, or a monotone cubic (Fritsch and Carlson).

    The spline has the same cubic in its first two pieces, and in its last two (not-a-knot).

    beyond : both ends: straight on, or the value of the end

    Raises ValueError : fewer than two points, x not in ascending order, non-finite numbers.
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
        words = str(error).replace("times", "x").replace("values", "y")
        raise ValueError(words) from error
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
    """Return the slope of the last piece but one at s."""
    c = law.coefficients[-2]
    return float(sum(i * c[i] * s ** (i - 1) for i in range(1, N_COEFFICIENT)))
