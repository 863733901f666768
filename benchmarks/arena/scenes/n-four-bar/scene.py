"""Uprights stay parallel: ((N + 1) / 3 + N) theta'' = -((N + 1) / 2 + N) g cos(theta), N = 2."""

import numpy as np
from scipy.integrate import solve_ivp


def truth(times: np.ndarray) -> np.ndarray:
    """Positions (k, 3) of the first upright's end [m]; inertia of a rod as the case has it."""
    n, rod = 2, 0.08333333333
    M, P = (n + 1) * (rod + 0.25) + n, (n + 1) / 2 + n

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -P * 9.81 * np.cos(y[0]) / M]

    found = solve_ivp(
        rates, (0, times[-1]), [np.pi / 2, -1.0], "DOP853", times, rtol=1e-13, atol=1e-14
    )
    return np.stack([np.cos(found.y[0]), np.sin(found.y[0]), 0.0 * times], axis=1)
