"""An input between communication points, from the values that came so far."""

import numpy as np

from ...math.arrays import Array

KEPT = 3  # values, enough for a parabola


class Course:
    """Polynomials in time for one input, each of one communication step.

    Only the past of an input is known, so a step uses the polynomial of `order` 0, 1 or 2 through
    its last values. A force takes it as it is. A drive is part of a constraint and must not jump:
    it goes by a polynomial of degree 5 from where it stands to the value, rate and acceleration
    that the polynomial has at the end of the step. Both have the same error, the third derivative
    of the input times h^3 for order 2.

    Parameters
    ----------
    drive : continuous with two derivatives
    order : of the polynomial
    start : (3,) value, rate, acceleration at t = 0
    """

    def __init__(self, start: Array, *, drive: bool, order: int) -> None:
        self._drive, self._order = drive, order
        self._at = np.array(start, dtype=float)  # of a drive, where it stands
        self._times: list[float] = []
        self._values: list[float] = []

    def piece(self, t: float, h: float, value: float, rates: Array) -> Array:
        """Return coefficients (6,) of powers of the time after t, for a step of h [s].

        value : of the input at t
        rates : (2,) first and second derivative at t where they are known; nan: not
        """
        if not self._times:
            # As if it had followed the parabola of its start before t.
            rate, acceleration = self._at[1:]
            for back in (-2.0 * h, -h):
                past = value + rate * back + 0.5 * acceleration * back**2
                self._note(t + back, float(past))
        self._note(t, value)
        ahead = self._ahead(t, value, rates)
        if not self._drive:
            return np.concatenate([ahead, np.zeros(3)])
        end = np.array(
            [
                ahead[0] + ahead[1] * h + ahead[2] * h * h,
                ahead[1] + 2.0 * ahead[2] * h,
                2.0 * ahead[2],
            ]
        )
        found = _join(self._at, end, h)
        self._at = end
        return found

    def _note(self, t: float, value: float) -> None:
        self._times, self._values = [*self._times, t][-KEPT:], [*self._values, value][-KEPT:]

    def _ahead(self, t: float, value: float, rates: Array) -> Array:
        """Return coefficients (3,) of the polynomial through the last values."""
        count = self._order + 1
        since = np.array(self._times[-count:]) - t
        found = np.zeros(3)
        found[0] = value
        known = np.isfinite(rates)
        if known[0]:
            found[1] = rates[0]
            if known[1]:
                found[2] = 0.5 * rates[1]
            elif self._order == 2:
                found[2] = (self._values[-2] - value - rates[0] * since[-2]) / since[-2] ** 2
        elif count > 1:
            rows = since[:-1, None] ** np.arange(1, count)
            change = np.array(self._values[-count:-1]) - value
            found[1:count] = np.linalg.solve(rows, change)
        return found


def _join(begin: Array, end: Array, h: float) -> Array:
    """Return coefficients (6,) of the quintic from (3,) to (3,) value, rate, acceleration in h."""
    c = np.zeros(6)
    c[:3] = begin[0], begin[1], 0.5 * begin[2]
    gap = end[0] - (c[0] + c[1] * h + c[2] * h * h)
    rate = (end[1] - (c[1] + 2.0 * c[2] * h)) * h
    acceleration = (end[2] - begin[2]) * h * h
    c[3] = (10.0 * gap - 4.0 * rate + 0.5 * acceleration) / h**3
    c[4] = (-15.0 * gap + 7.0 * rate - acceleration) / h**4
    c[5] = (6.0 * gap - 3.0 * rate + 0.5 * acceleration) / h**5
    return c
