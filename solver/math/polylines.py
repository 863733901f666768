"""Lines through points, straight between them."""

import numpy as np

from .arrays import Array


def lengths_along(points: Array) -> Array:
    """Return the length of the line through points (n, d) up to each of them, (n,), from 0 [m]."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
