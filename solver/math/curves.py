"""Curves y(x) through points, as piecewise polynomials like the laws of time."""

from collections.abc import Sequence

import numpy as np

from .laws import N_COEFFICIENT, Law, table


def curve(x: Sequence[float], y: Sequence[float], *, smooth: bool = True) -> Law:
    """Return a natural cubic spline, or straight lines; straight on beyond both ends.

    Raises ValueError : fewer than two points, x not in ascending order, non-finite numbers.
    """
    try:
        inner = table(x, y, smooth=False)
    except ValueError as error:
        words = str(error).replace("times", "x").replace("values", "y")
        raise ValueError(words) from error
    if smooth and len(x) > 2:
        from scipy.interpolate import CubicSpline  # 0.1 s: only for curves

        found = CubicSpline(x, y, bc_type="natural")
        inner.coefficients[:-1, :4] = found.c[::-1].T
    slopes = inner.coefficients[0, 1], _slope(inner, float(x[-1] - x[-2]))
    outer = np.zeros((2, N_COEFFICIENT))
    outer[0, :2], outer[1, :2] = (y[0], slopes[0]), (y[-1], slopes[1])
    return Law(
        np.array([x[0], *inner.times]),
        np.concatenate([outer[:1], inner.coefficients[:-1], outer[1:]]),
    )


def _slope(law: Law, s: float) -> float:
    """Return the slope of the last piece but one at s."""
    c = law.coefficients[-2]
    return float(sum(i * c[i] * s ** (i - 1) for i in range(1, N_COEFFICIENT)))
