"""Size of a first step, from the sizes of the state, its rate, and the change of the rate."""

from collections.abc import Callable

import numpy as np

from ...math.arrays import Array
from .norm import ErrorNorm


def first_step_size(
    derivative: Callable[[float, Array], Array],
    t: float,
    y: Array,
    rate: Array,
    norm: ErrorNorm,
    order: int,
    span: float,
    max_step: float,
) -> float:
    """Return the size of the first step [s] of a method of this order; one evaluation.

    Parameters
    ----------
    derivative : f(t, y) -> (n,)
    y, rate : (n,) state and its rate at t [s]
    span : length of the run [s]
    """
    weight = norm.weight(y, y)
    size_y = norm(y * weight)
    size_f = norm(rate * weight)
    h = 0.01 * size_y / size_f if min(size_y, size_f) > 1e-5 else 1e-6
    h = max(min(h, span, max_step), 1e-300)  # f may be beyond all measure
    change = norm((derivative(t + h, y + h * rate) - rate) * weight) / h
    if not np.isfinite(change):
        return 0.01 * h
    largest = max(size_f, change)
    if largest <= 1e-15:
        return min(100 * h, span)
    return min(100 * h, (0.01 / largest) ** (1 / (order + 1)), span)
