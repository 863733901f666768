"""Disc 4 kg, 1 mm off its axis, J = 0.02 kg m2 about its centre; carriages 0.5 kg each."""

import numpy as np
from scipy.integrate import solve_ivp


def truth(times: np.ndarray) -> np.ndarray:
    """Positions (k, 3) of a place 0.1 m from the axis [m]."""
    m, e, k, c = 4.0, 1e-3, 4e4, 30.0

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        X, Y, a, u, v, w = y
        s, co = np.sin(a), np.cos(a)
        M = np.array([[m + 1.0, 0, -m * e * s], [0, m + 0.5, m * e * co],
                      [-m * e * s, m * e * co, 0.02 + m * e * e]])  # fmt: skip
        f = [m * e * w * w * co - k * X - c * u, m * e * w * w * s - k * Y - c * v, 2.0]
        return np.concatenate([y[3:], np.linalg.solve(M, f)])

    found = solve_ivp(rates, (0, times[-1]), np.zeros(6), "DOP853", times, rtol=1e-13, atol=1e-15)
    X, Y, a = found.y[:3]
    return np.stack([X + 0.1 * np.cos(a), Y + 0.1 * np.sin(a), 0.0 * X], axis=1)
