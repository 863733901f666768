"""Strength ratio of a stress: the closed-form solution for proportional loading."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array, IntArray


@dataclass(frozen=True)
class Verdict:
    """Result of a criterion for stresses (..., 6); the arrays have the shape (...)."""

    exposure: Array  # 1 / R: 0 without stress, 1 at failure, proportional to the stress [-]
    index: Array  # value of the governing condition, 1 at failure [-]
    mode: IntArray  # which condition governs: a number of `modes`
    modes: tuple[str, ...]

    @property
    def ratio(self) -> Array:
        """Strength ratio R: failure at R times the stress; margin of safety R - 1."""
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(1.0 / self.exposure)


def exposure(quadratic: Array, linear: Array) -> Array:
    """1 / R of the condition quadratic R^2 + linear R = 1; 0 if no R > 0 fulfils it.

    Of two positive solutions, the smaller R is used. Both branches avoid the difference of nearly
    equal numbers.
    """
    a, b = np.asarray(quadratic, dtype=float), np.asarray(linear, dtype=float)
    under = b * b + 4.0 * a
    root = np.sqrt(np.maximum(under, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(b >= 0.0, 0.5 * (b + root), 2.0 * a / (root - b))
    return np.asarray(np.where((under < 0.0) | ((a <= 0.0) & (b <= 0.0)), 0.0, found))


def governing(modes: tuple[str, ...], exposures: list[Array], indices: list[Array]) -> Verdict:
    """The condition of the highest exposure at every point."""
    E, index = np.stack(exposures), np.stack(indices)
    mode = np.argmax(E, axis=0)
    pick: NDArray[np.int64] = mode[None]
    return Verdict(
        np.take_along_axis(E, pick, 0)[0], np.take_along_axis(index, pick, 0)[0], mode, modes
    )
