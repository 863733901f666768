"""Single numbers of a signal over time, and its amplitude spectrum."""

import numpy as np

from ..math.arrays import Array

EVEN = 1e-6  # of the output step: times that differ less are equally spaced
WINDOWS = ("hann", "none")


class SquareIntegral:
    """Integral of the square of a signal over time, taken block by block (trapezoidal rule).

    Intervals with NaN or inf at an end are left out.
    """

    def __init__(self) -> None:
        self._integral, self._length = 0.0, 0.0
        self._t, self._square = np.zeros(0), np.zeros(0)  # the last sample of the block before

    def take(self, t: Array, values: Array) -> None:
        """Add a block: times (k,) [s] and values (k,)."""
        t = np.concatenate([self._t, t])
        with np.errstate(over="ignore"):
            square = np.concatenate([self._square, np.square(values)])
        step = np.diff(t)
        mean = 0.5 * (square[1:] + square[:-1])
        known = np.isfinite(mean)
        self._integral += float(mean[known] @ step[known])
        self._length += float(step[known].sum())
        self._t, self._square = t[-1:], square[-1:]

    def rms(self) -> float | None:
        """Return the root mean square over time; of a single sample its magnitude."""
        if self._length > 0.0:
            return float(np.sqrt(self._integral / self._length))
        known = self._square[np.isfinite(self._square)]
        return float(np.sqrt(known[-1])) if known.size else None


def spectrum(t: Array, values: Array, window: str = "hann") -> tuple[Array, Array]:
    """Return frequencies (m,) [Hz] and amplitudes (m,) of a signal, in the unit of the signal.

    The mean is subtracted. A sine whose frequency is one of those returned has its amplitude
    there; a last interval that is shorter than the others is left out.

    Parameters
    ----------
    t, values : (k,)
    window : "hann" (less leakage between frequencies) or "none"

    Raises
    ------
    ValueError
        Fewer than four times, times at different distances, a value that is not finite, or
        another window.
    """
    t, values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)
    if window not in WINDOWS:
        raise ValueError(f"window = {window!r}: expected one of {', '.join(WINDOWS)}")
    if len(t) > 2 and t[-1] - t[-2] < (t[1] - t[0]) * (1.0 - EVEN):
        t, values = t[:-1], values[:-1]
    if len(t) < 4:
        raise ValueError(f"spectrum: expected four output times or more, found {len(t)}")
    step = np.diff(t)
    if np.ptp(step) > EVEN * step[0]:
        raise ValueError("spectrum: expected output times at equal distances")
    if not np.isfinite(values).all():
        raise ValueError("spectrum: expected finite values only")
    n = len(t)
    # periodic form: its samples follow each other without a double end
    weight = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n) if window == "hann" else np.ones(n)
    mean = float(weight @ values) / float(weight.sum())
    amplitude = np.abs(np.fft.rfft(weight * (values - mean))) / weight.sum()
    amplitude[1 : None if n % 2 else -1] *= 2.0  # both signs of the frequency
    frequency = np.asarray(np.fft.rfftfreq(n, float(np.mean(step))), dtype=float)
    return frequency, np.asarray(amplitude)
