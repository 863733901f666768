"""Vibrations that a start from rest leaves, of frequencies that output times do not resolve.

Bodies start in the quasi-static shape, but at rest: the shape moves, and each mode rings with the
amplitude eta_d / w, undamped. Newmark's method damps what the output times do not resolve. These
vibrations are therefore added in closed form, with the masses of the start.
"""

from dataclasses import dataclass

import numpy as np

from ..math.arrays import Array

RESOLVED = 0.15  # frequency times step up to which Newmark's method keeps a vibration
MASSLESS = 1e-14  # of the largest inverse squared frequency: a direction that joints hold


@dataclass(frozen=True)
class Ringing:
    """Vibrations k of the modes m after the start.

    Attributes
    ----------
    rate : (m,) rates without them, at the start
    shapes : (m, k) amplitudes of the modes
    w, decay : (k,) frequencies [rad/s] and rates of decay [1/s]
    """

    rate: Array
    shapes: Array
    w: Array
    decay: Array

    def history(self, t: Array) -> tuple[Array, Array, Array]:
        """Return coordinates, rates and accelerations (k, m) at times t from the start."""
        phase = np.outer(t, self.w)
        fading = np.exp(-np.outer(t, self.decay))
        sine, cosine = np.sin(phase) * fading, np.cos(phase) * fading
        q = sine @ self.shapes.T
        return q, cosine @ (self.shapes * self.w).T, -sine @ (self.shapes * self.w**2).T


def ringing(M: Array, K: Array, D: Array, rate: Array, step: float) -> Ringing:
    """Return the vibrations that a start from rest leaves if the quasi-static shape has a `rate`.

    Parameters
    ----------
    M, K, D : (m, m) of the modes
    rate : (m,) of the quasi-static coordinates at the start
    step : between output times [s]
    """
    root = np.linalg.inv(np.linalg.cholesky(K))  # K = C C'
    inverse, U = np.linalg.eigh(root @ (0.5 * (M + M.T)) @ root.T)
    some = inverse > max(MASSLESS * float(inverse[-1]), 1e-300)
    some &= inverse * RESOLVED**2 < step**2
    w, X = 1.0 / np.sqrt(inverse[some]), root.T @ U[:, some]
    moved = X.T @ M @ rate * w  # X has a stiffness of 1
    decay = 0.5 * w**2 * (X * (D @ X)).sum(axis=0)
    return Ringing(X @ (w * moved), -X * moved, w, decay)
