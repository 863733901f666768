"""Curves y(x) through points, as piecewise polynomials like the laws of time."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from . import laws
from .laws import N_COEFFICIENT, Law, Numbers, table

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
