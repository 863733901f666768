"""Weights of the error norm, the norm itself, and numbers that are not finite."""

import numpy as np

from ...math.arrays import Array
from ...math.compiled import inlined
from .step_control import Options


@inlined
def set_weights(options: Options, a: Array, b: Array, weight: Array) -> None:
    """Fill weight (n,) with 1 / (atol + rtol max(|a|, |b|))."""
    for i in range(a.shape[0]):
        weight[i] = 1.0 / (options.atol[i] + options.rtol * max(abs(a[i]), abs(b[i])))


@inlined
def norm(options: Options, a: Array, weight: Array) -> float:
    """Largest of the blocks' root mean squares, nan if there is one; see generic/norm.py."""
    largest = 0.0
    for b in range(options.block_starts.shape[0] - 1):
        s = 0.0
        for i in range(options.block_starts[b], options.block_starts[b + 1]):
            s += (a[i] * weight[i]) ** 2
        s /= options.block_starts[b + 1] - options.block_starts[b]
        if s > largest or s != s:  # nan stays
            largest = s
    return float(np.sqrt(largest))


@inlined
def largest_component(a: Array, weight: Array) -> int:
    """Component of the largest of a (n,) in its weight."""
    most, at = -1.0, 0
    for i in range(a.shape[0]):
        size = abs(a[i] * weight[i])
        if size > most:
            most, at = size, i
    return at


@inlined
def finite(a: Array) -> bool:
    """Tell whether no number is inf or nan."""
    s = 0.0
    for i in range(a.shape[0]):
        s += abs(a[i])
    return bool(s < 1e300)
