"""theta'' = -w0^2 sin(theta), w0^2 = 3 g / (2 L): sin(theta / 2) = k sn(K(k) - w0 t, k)."""

import numpy as np
from scipy.special import ellipj, ellipk


def truth(times: np.ndarray) -> np.ndarray:
    """Positions (k, 3) of the tip [m]."""
    m = np.sin(np.pi / 4.0) ** 2
    sn = ellipj(ellipk(m) - np.sqrt(1.5 * 9.81) * times, m)[0]
    angle = 2.0 * np.arcsin(np.sqrt(m) * sn)  # from the downward vertical
    return np.stack([-np.sin(angle), -np.cos(angle), 0.0 * times], axis=1)
