"""1 kg, 5 N s/m; u = 50 (1 - x) at 0, 0.02, 0.04, ... s, held in between."""

import numpy as np


def truth(times: np.ndarray) -> np.ndarray:
    """Positions (k, 3) [m]; in an interval v -> u / c + (v - u / c) exp(-c t)."""
    c, period, x, v = 5.0, 0.02, 0.0, 0.0
    found = np.zeros((len(times), 3))
    for k in range(round(times[-1] / period)):
        u = 50.0 * (1.0 - x)

        def at(t: np.ndarray, x: float = x, v: float = v, u: float = u) -> np.ndarray:
            return x + u / c * t + (v - u / c) * (1.0 - np.exp(-c * t)) / c

        own = (times > k * period + 1e-9) & (times < (k + 1) * period + 1e-9)
        found[own, 0] = at(times[own] - k * period)
        x, v = float(at(period)), u / c + (v - u / c) * np.exp(-c * period)
    return found
