"""Released at 0.5 m, k = 100 N/m, 1 kg, 2 N: a half cycle of pi / 10 s takes 2 F / k = 0.04 m."""

import numpy as np


def truth(times: np.ndarray) -> np.ndarray:
    """Positions (k, 3) [m]."""
    shift, half = 0.02, np.pi / 10.0
    x, amplitude, start = np.zeros_like(times), 0.5, 0.0
    side = 1.0
    while amplitude > shift:
        during = times >= start
        x[during] = side * (shift + (amplitude - shift) * np.cos(10.0 * (times[during] - start)))
        amplitude, start, side = amplitude - 2.0 * shift, start + half, -side
    x[times >= start] = side * amplitude
    return np.stack([x, 0.0 * x, 0.0 * x], axis=1)
