"""Flap of a uniform Bernoulli beam that spins: power series (Frobenius), as Wright et al. (1982).

EI = rhoA = L = 1: w'''' - (T w')' - omega^2 w = 0 with the tension
T = mu^2 / 2 (1 + 2 hub - 2 hub x - x^2); w = w' = 0 at the root, w'' = w''' = 0 at the tip.
"""

import numpy as np
from scipy.optimize import brentq

TERMS = 90
GRID = np.arange(1.0, 120.0)  # no two frequencies are closer


def at_tip(omega, mu: float, hub: float):
    """Determinant of w'' and w''' at the tip of the solutions x^2 + ... and x^3 + ..."""
    omega = np.asarray(omega)
    c = np.zeros((TERMS + 4, 2, *omega.shape))
    c[2, 0] = c[3, 1] = 1.0
    for k in range(TERMS):
        pulled = (1.0 + 2.0 * hub) * (k + 2) * c[k + 2] - 2.0 * hub * (k + 1) * c[k + 1] - k * c[k]
        load = 0.5 * mu**2 * (k + 1) * pulled + omega**2 * c[k]
        c[k + 4] = load / ((k + 4) * (k + 3) * (k + 2) * (k + 1))
    k = np.arange(TERMS + 4)
    (a, b), (d, e) = (np.tensordot(w, c, 1) for w in (k * (k - 1), k * (k - 1) * (k - 2)))
    return (a * e - b * d) / (abs(a * e) + abs(b * d))


def flap(mu: float, hub: float, n: int) -> list[float]:
    """The lowest n frequencies, over sqrt(EI / (rhoA L^4))."""
    turns = np.flatnonzero(np.diff(np.sign(at_tip(GRID, mu, hub))))[:n]
    return [brentq(at_tip, GRID[k], GRID[k + 1], (mu, hub), xtol=1e-11) for k in turns]
