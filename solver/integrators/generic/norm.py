"""The size of a local error, and of a first step that follows from it."""

from collections.abc import Callable, Sequence
from math import sqrt

import numpy as np

from ...math.arrays import Array


class ErrorNorm:
    """Tolerances of n components, and the norm in which an error of 1 is just acceptable.

    Blocks keep a few badly resolved components (the modal coordinates of one body, say)
    from being averaged away among many good ones.

    Parameters
    ----------
    n : number of components
    rtol : relative tolerance [-]; raised to 100 machine epsilons if smaller but not zero
    atol : absolute tolerance, scalar or (n,), in the unit of y
    block_starts : first index of each block, ascending from 0; one block if None

    Raises
    ------
    ValueError : negative or missing tolerance, blocks out of order
    """

    def __init__(
        self, n: int, rtol: float, atol: float | Array, block_starts: Sequence[int] | None
    ) -> None:
        if not 0 < rtol < 1:
            raise ValueError(f"rtol: expected a number between 0 and 1, got {rtol!r}")
        self.rtol = max(rtol, 100 * float(np.finfo(float).eps))
        self.atol = np.array(np.broadcast_to(np.asarray(atol, dtype=float), (n,)))
        if not (self.atol >= 0).all():
            raise ValueError(f"atol: expected numbers of at least 0 in the unit of y, got {atol!r}")
        starts = np.asarray([0] if block_starts is None else block_starts, dtype=np.int64)
        if starts.size == 0 or starts[0] != 0 or (np.diff(starts) <= 0).any() or starts[-1] >= n:
            raise ValueError(
                f"block_starts: expected ascending indices from 0, below {n}, got {block_starts!r}"
            )
        self._n = n
        self._starts = starts if starts.size > 1 else None
        self._sizes = np.diff(np.append(starts, n)).astype(float)

    def weight(self, y_a: Array, y_b: Array) -> Array:
        """1 / (atol + rtol max(|y_a|, |y_b|)), (n,)."""
        scale = np.maximum(np.abs(y_a), np.abs(y_b))
        scale *= self.rtol
        scale += self.atol
        return np.divide(1.0, scale, out=scale)

    def __call__(self, weighted: Array) -> float:
        """Norm of a weighted vector (n,); inf or nan if it holds such numbers."""
        if self._starts is None:
            return sqrt(weighted.dot(weighted) / self._n)
        squares = np.add.reduceat(weighted * weighted, self._starts)
        squares /= self._sizes
        return sqrt(squares.max())


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
