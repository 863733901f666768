"""Search for the point and time of highest exposure of a section under a history of resultants.

Exposures are proportional to the stress, and the stress of a point is linear in the six
resultants. A convex bound u of the exposure therefore obeys the triangle inequality,

    exposure(F) <= u(F) <= sum_j  F_j+ u(e_j) + F_j- u(-e_j),   F_j+, F_j- >= 0,

with u(e_j) of each point under each unit resultant computed once per section. The largest F_j+ and
F_j- of a block of times bound the whole block, which excludes most points and blocks. The others
are bounded for each time, and the criterion is evaluated in descending order of the bounds,
until no bound is above the highest exposure found. The result is therefore exact.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..math.arrays import Array, IntArray
from . import Criterion

BLOCK = 16  # times per block
BOUNDS = 2_000_000  # pairs of point and time bounded together
BATCH = 2048  # pairs evaluated together
ROUND_OFF = 1e-12  # relative tolerance of a bound that equals the exposure


@dataclass(frozen=True)
class Peak:
    """The highest exposure of a history, with point and time; without any exposure, the first
    point."""

    exposure: float
    point: int
    instant: int


class PeakSearch:
    """The search prepared for the points of one material.

    Parameters
    ----------
    stress_M : (p, 6, 6) stress of each point in its ply axes per unit resultant [Pa/N, Pa/(N m)]
    criterion, strength : failure criterion and strengths of the material
    """

    def __init__(self, stress_M: Array, criterion: Criterion, strength: Any) -> None:
        self.stress_M = stress_M
        self.criterion, self.strength = criterion, strength
        unit = np.moveaxis(stress_M, 2, 1)  # (p, resultant, stress)
        both = np.concatenate([unit, -unit], axis=1)
        self.bounds: Array = criterion.bound(both, strength)  # (p, 12)

    def peak(self, F: Array, floor: float = 0.0) -> Peak:
        """Find the peak of resultants F (6, t).

        Peaks below `floor` are not needed: the search then ends early, and its result
        is not above the floor.
        """
        parts = np.maximum(np.concatenate([F, -F]), 0.0) * (1.0 + ROUND_OFF)
        starts = np.arange(0, F.shape[1], BLOCK)
        coarse = self.bounds @ np.maximum.reduceat(parts, starts, axis=1)  # (p, blocks)
        point, block = np.unravel_index(np.argmax(coarse), coarse.shape)
        first = np.arange(F.shape[1])[starts[block] : starts[block] + BLOCK]
        best = self._better(F, np.full(len(first), point), first, Peak(0.0, 0, 0))

        left = coarse > max(floor, best.exposure)
        points = np.flatnonzero(left.any(axis=1))
        instants = np.flatnonzero(np.repeat(left.any(axis=0), BLOCK)[: F.shape[1]])
        step = max(1, BOUNDS // max(1, len(points)))
        for start in range(0, len(instants), step):
            part = instants[start : start + step]
            best = self._worst_of(
                F, points, part, self.bounds[points] @ parts[:, part], floor, best
            )
        return best

    def _worst_of(
        self, F: Array, points: IntArray, instants: IntArray, upper: Array, floor: float, best: Peak
    ) -> Peak:
        """The higher of `best` and the peak among all points and times, bounded by `upper`."""
        # Evaluating each point at the time of its highest bound gives a level that few pairs
        # exceed.
        best = self._better(F, points, instants[np.argmax(upper, axis=1)], best)
        row, column = np.nonzero(upper > max(floor, best.exposure))
        own = upper[row, column]
        order = np.argsort(-own, kind="stable")
        for start in range(0, len(order), BATCH):
            batch = order[start : start + BATCH]
            if own[batch[0]] <= max(floor, best.exposure):
                break
            best = self._better(F, points[row[batch]], instants[column[batch]], best)
        return best

    def _better(self, F: Array, points: IntArray, instants: IntArray, best: Peak) -> Peak:
        """The higher of `best` and the peak among pairs of point and time, each (k,)."""
        stress = np.einsum("kij,jk->ki", self.stress_M[points], F[:, instants])
        found = self.criterion.assess(stress, self.strength).exposure
        k = int(np.argmax(found))
        if not found[k] > best.exposure:
            return best
        return Peak(float(found[k]), int(points[k]), int(instants[k]))
