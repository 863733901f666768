"""A cubic spline through points in space, measured along itself."""

import numpy as np

from ...math.arrays import Array
from ...math.polylines import lengths_along

FINE = 2000  # steps of a spline through points, at least


class Spline:
    """A curve through points.

    Attributes
    ----------
    knots : (k,) places of the points along the polygon through them [m]
    u : (n,) fine division of the same parameter, with all knots
    along : (n,) length of the curve up to there [m]
    tangents : (n, 3) unit vectors
    """

    def __init__(self, points: Array) -> None:
        from scipy.interpolate import CubicSpline  # 0.3 s: only for lines through points

        self.knots = lengths_along(points)
        self._curve = CubicSpline(self.knots, points)
        parts = max(FINE // (len(self.knots) - 1), 20)
        first, last = self.knots[:-1], self.knots[1:]
        u = np.append(np.linspace(first, last, parts, endpoint=False).T.ravel(), last[-1])
        speed = np.linalg.norm(self._curve(u, 1), axis=1)
        middle = np.linalg.norm(self._curve(0.5 * (u[:-1] + u[1:]), 1), axis=1)
        steps = np.diff(u) * (speed[:-1] + 4.0 * middle + speed[1:]) / 6.0  # Simpson
        self.u, self.along = u, np.concatenate([[0.0], np.cumsum(steps)])
        self.tangents = self._curve(u, 1) / speed[:, None]
        self._inverse = CubicSpline(self.along / self.along[-1], u)

    @property
    def length(self) -> float:
        """Length of the curve [m]."""
        return float(self.along[-1])

    @property
    def fractions(self) -> Array:
        """Places of the points as fractions of the length, (k,)."""
        return np.asarray(self.along[np.searchsorted(self.u, self.knots)] / self.along[-1])

    def parameter(self, s: Array) -> Array:
        """Parameter at fractions of the length (m,)."""
        return np.asarray(self._inverse(s))

    def place(self, s: Array) -> Array:
        """Positions (m, 3) at fractions of the length [m]."""
        return np.asarray(self._curve(self.parameter(s)))

    def tangent(self, s: Array) -> Array:
        """Unit tangents (m, 3) at fractions of the length."""
        found = self._curve(self.parameter(s), 1)
        return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))
