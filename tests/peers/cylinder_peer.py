"""A second route to the buckling of laminated cylinders with simply supported ends: Ritz series.

Sanders' shell with transverse shear: u, v, w along x, around and outwards, rotations bx, bs of the
normal (u + z bx). Both ends hold v, w and bs, and leave u free (SS3) or hold it too (SS4). For each
number n of waves around, the unknowns are sums of sin(m pi x/L) for what is held and cos(m pi x/L)
for the others, times cos(n t) and sin(n t). Cross plies under compression and pressure with ends
SS3 need one m at a time: exact solutions.

It reads nothing of the finite elements.
"""

from functools import cache
from typing import Any

import numpy as np
import scipy.linalg

leggauss = cache(np.polynomial.legendre.leggauss)
U, V, W, X, Y = range(5)


SS3, SS4 = (U, X), (X,)  # fields that are free at the ends


def fields(n: int, R: float, L: float, x: Any, t: float, terms: Any, free: Any) -> tuple[Any, Any]:
    """Values and derivatives by x and s of the five fields: (q, 5, k), (q, 5, 2, k)."""
    values, slopes = [], []
    for field in range(5):
        for m in terms:
            a = m * np.pi / L
            if field in free:
                f, df = np.cos(a * x), -a * np.sin(a * x)
            else:
                f, df = np.sin(a * x), a * np.cos(a * x)
            for g, dg in ((np.cos(n * t), -n * np.sin(n * t)), (np.sin(n * t), n * np.cos(n * t))):
                value, slope = np.zeros((len(x), 5)), np.zeros((len(x), 5, 2))
                value[:, field] = f * g
                slope[:, field, 0], slope[:, field, 1] = df * g, f * dg / R
                values.append(value)
                slopes.append(slope)
    return np.stack(values, axis=-1), np.stack(slopes, axis=-1)


def matrices(
    C: Any, Ds: Any, R: float, L: float, n: int, terms: Any, N: Any, p: float, free: Any = SS3
) -> tuple[Any, Any]:
    """K, and Kg with the load stiffness of a pressure p (outwards) that follows the surface."""
    points, weights = leggauss(2 * max(terms) + 6)
    x, weight = 0.5 * L * (points + 1.0), 0.5 * L * weights
    K: Any = 0.0
    G: Any = 0.0
    for phase in range(4):
        t = 0.5 * np.pi * phase / n
        q, d = fields(n, R, L, x, t, terms, free)
        turn = 0.5 * (d[:, V, 0] - d[:, U, 1])
        rows = [
            d[:, U, 0],
            d[:, V, 1] + q[:, W] / R,
            d[:, U, 1] + d[:, V, 0],
            d[:, X, 0],
            d[:, Y, 1],
            d[:, X, 1] + d[:, Y, 0] - turn / R,
        ]
        slope_x, slope_s = d[:, W, 0], d[:, W, 1] - q[:, V] / R
        e = np.stack(rows, axis=1)
        g = np.stack([slope_x + q[:, X], slope_s + q[:, Y]], axis=1)
        for strain, stiffness in ((e, C), (g, Ds)):
            weighted = (weight[:, None, None] * strain).reshape(-1, strain.shape[-1])
            K = K + weighted.T @ (stiffness @ strain).reshape(weighted.shape)

        def product(a: Any, b: Any) -> Any:
            both = a.T @ (weight[:, None] * b)
            return 0.5 * (both + both.T)

        G = G + N[0] * product(slope_x, slope_x) + N[1] * product(slope_s, slope_s)
        G = G + 2.0 * N[2] * product(slope_x, slope_s) + (N[0] + N[1]) * product(turn, turn)
        if p:
            opened = d[:, U, 0] + d[:, V, 1]
            G = G - p * 2.0 * product(q[:, W], opened)
            G = G - p / R * (product(q[:, W], q[:, W]) + product(q[:, V], q[:, V]))
    return K, G


def factor(
    C: Any, Ds: Any, R: float, L: float, n: int, terms: Any, N: Any, p: float = 0.0, free: Any = SS3
) -> float:
    """The smallest load factor with n waves around and the given numbers of half waves along.

    C (6, 6) of (N, M) in x, s and Ds (2, 2); N (Nx, Ns, Nxs) [N/m] and p [Pa] of the unit load.
    """
    K, G = matrices(C, Ds, R, L, n, terms, N, p, free)
    kept = np.diag(K) > 1e-12 * np.diag(K).max()  # sin(0 x) is no function
    mu = scipy.linalg.eigh(-G[np.ix_(kept, kept)], K[np.ix_(kept, kept)], eigvals_only=True)
    return float(1.0 / mu[-1]) if mu[-1] > 0 else np.inf


def smallest(
    C: Any, Ds: Any, R: float, L: float, waves: Any, along: Any, N: Any, p: float = 0.0
) -> tuple[float, int, int]:
    """The smallest factor with one half-wave number at a time, and its n and m."""
    found = [(factor(C, Ds, R, L, n, [m], N, p), n, m) for n in waves for m in along]
    return min(found)


def frequency(
    C: Any, Ds: Any, R: float, L: float, n: int, m: int, N: Any, mass: tuple[float, float]
) -> float:
    """The smallest natural frequency [rad/s] under the resultants N, of one n and one m.

    `mass` are the moments of density 1 and z^2 over the thickness.
    """
    K, G = matrices(C, Ds, R, L, n, [m], N, 0.0)
    M: Any = 0.0
    points, weights = leggauss(2 * m + 6)
    for phase in range(4):
        q, _ = fields(n, R, L, 0.5 * L * (points + 1.0), 0.5 * np.pi * phase / n, [m], SS3)
        for part, moment in ((q[:, :3], mass[0]), (q[:, 3:], mass[1])):
            M = M + moment * np.einsum("q,qia,qib->ab", 0.5 * L * weights, part, part)
    return float(np.sqrt(scipy.linalg.eigh(K + G, M, eigvals_only=True)[0]))
