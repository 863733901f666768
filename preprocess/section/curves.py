"""Nearest point on a curve of line elements."""

import numpy as np

from ...solver.math.arrays import Array

SAMPLES = 8  # per element, to find the nearest element
CANDIDATES = 4  # candidate elements for each point
NEWTON_STEPS = 8


def nearest_on_curve(segments: Array, x: Array) -> Array:
    """Nearest point on a curve for each of some points, (p, 2).

    Parameters
    ----------
    segments : (s, 2 or 3, 2) end points of the line elements, then the middle node
    x : (p, 2) points
    """
    from scipy.spatial import cKDTree  # here: few sections have curves

    a, b = segments[:, 0], segments[:, 1]
    # position = mean + half s + bow s^2 for s from -1 to 1
    middle = segments[:, 2] if segments.shape[1] == 3 else 0.5 * (a + b)
    half, bow = 0.5 * (b - a), 0.5 * (a + b) - middle
    s = np.linspace(-1.0, 1.0, SAMPLES + 1)[:, None, None]
    samples = middle + half * s + bow * s**2  # (SAMPLES + 1, s, 2)
    tree = cKDTree(samples.reshape(-1, 2))
    _, near = tree.query(x, k=min(CANDIDATES * 2, samples.shape[0] * samples.shape[1]))
    element = near % len(segments)
    s0 = -1.0 + 2.0 * (near // len(segments)) / SAMPLES
    c, h, w = middle[element], half[element], bow[element]  # (p, candidates, 2)
    for _ in range(NEWTON_STEPS):
        away = c + h * s0[..., None] + w * s0[..., None] ** 2 - x[:, None]
        slope = h + 2.0 * w * s0[..., None]
        first = np.einsum("pki,pki->pk", away, slope)
        second = np.einsum("pki,pki->pk", slope, slope) + 2.0 * np.einsum("pki,pki->pk", away, w)
        # where the distance is not convex, a Gauss-Newton step still reduces it
        convex = np.einsum("pki,pki->pk", slope, slope)
        s0 = np.clip(s0 - first / np.where(second > 0.1 * convex, second, convex), -1.0, 1.0)
    feet = c + h * s0[..., None] + w * s0[..., None] ** 2
    best = np.argmin(np.linalg.norm(feet - x[:, None], axis=-1), axis=1)
    return np.asarray(feet[np.arange(len(x)), best])
