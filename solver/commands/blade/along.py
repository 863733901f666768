"""Quantities along the span of a blade."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...math.arrays import Array

NEAR = 1e-9  # of the span: distance that is round-off


@dataclass(frozen=True)
class Along:
    """A quantity over the span, linear between its points."""

    grid: Array  # (n,) rising, of 0 to 1
    values: Array  # (n,)

    def at(self, r: float) -> float:
        """Value at r of 0 to 1; outside of the grid that of its end."""
        return float(np.interp(r, self.grid, self.values))

    def covers(self, r: float) -> bool:
        """True if r is within the grid: what a file gives on a part of the span is only there."""
        return bool(self.grid[0] - NEAR <= r <= self.grid[-1] + NEAR)

    def smooth(self, r: Array) -> Array:
        """Values at r (n,) of a monotone cubic curve through its points."""
        grid, first = np.unique(self.grid, return_index=True)
        if len(grid) < 2:
            return np.full(len(r), self.values[0])
        inside = np.clip(r, grid[0], grid[-1])
        return np.asarray(PchipInterpolator(grid, self.values[first])(inside))


STRAIGHT = Along(np.zeros(1), np.zeros(1))
WHOLE = STRAIGHT, Along(np.zeros(1), np.ones(1))  # start and end of all of a web
