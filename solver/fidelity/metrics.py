"""How two histories of a signal are compared, and against which scale."""

import numpy as np

from ..math.arrays import Array


def difference(metric: str, one: Array, two: Array) -> Array:
    """Return the difference of histories (..., k) by a metric of `[fidelity]`, (...)."""
    if metric == "extremum":
        high = np.abs(one.max(axis=-1) - two.max(axis=-1))
        return np.asarray(np.maximum(high, np.abs(one.min(axis=-1) - two.min(axis=-1))))
    gap = np.asarray(one - two)
    if metric == "rms":
        return np.asarray(np.sqrt(np.mean(gap**2, axis=-1)))
    return np.asarray(np.abs(gap).max(axis=-1))


def scales(metric: str, values: Array) -> Array:
    """Return the largest value of signals (o, k), or their root mean square, (o,); 1 where zero."""
    sizes = np.sqrt(np.mean(values**2, axis=-1)) if metric == "rms" else np.abs(values).max(axis=-1)
    return np.where(sizes > 0.0, sizes, 1.0)
