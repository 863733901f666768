"""Search for the point and time of highest exposure of a section under a history of resultants.

Exposures are proportional to the stress, and the stress of a point is linear in the six
resultants. A convex bound u of the exposure therefore obeys the triangle inequality,

    exposure(F) <= u(F) <= sum_j  F_j+ u(e_j) + F_j- u(-e_j),   F_j+, F_j- >= 0,

with u(e_j) of each point under each unit resultant computed once per section. The largest F_j+ and
F_j- of a block of times bound the whole block, which excludes most points.

For the points that are left, the two resultants that matter most are written in the two nearest of
`FAN` directions of their plane instead: the bound is then at most a few per cent too high. Times of
one direction and of like size form a block. The criterion is evaluated in descending order of the
bounds, until no bound is above the highest exposure found. The result is therefore exact.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..math.arrays import Array, IntArray
from . import Criterion

BLOCK = 16  # times per block
FAN = 16  # directions in the plane of the two largest resultants
FINE = 8  # of parts into which times between two of them are sorted
BATCH = 128  # pairs of point and block evaluated together
ROUND_OFF = 1e-12  # relative tolerance of a bound that equals the exposure


@dataclass(frozen=True)
class Peak:
    """The highest exposure of a history, with point and time; without any exposure, the first
    point."""

    exposure: float
    point: int
    instant: int


class Peaks:
    """The highest exposure of every group of points so far, with point and time.

    Attributes
    ----------
    group : (p,) of each point
    exposure, point, instant : (g,); without any exposure, the first point of the group
    floors : (g,) peaks of a group below its floor are not needed, unless above `top`
    top : highest exposure of all
    """

    def __init__(self, group: IntArray, floors: Array, top: float) -> None:
        self.group, self.floors, self.top = group, floors, top
        count = floors.size
        self.exposure, self.instant = np.zeros(count), np.zeros(count, dtype=np.int64)
        self.point = np.array([int(np.argmax(group == g)) for g in range(count)])

    def level(self) -> Array:
        """Exposure that is not of interest, for each group (g,)."""
        return np.minimum(np.maximum(self.floors, self.exposure), self.top)

    def take(self, exposure: Array, points: IntArray, instants: IntArray) -> None:
        """Take exposures of pairs of point and time, (k,) each."""
        own = self.group[points]
        order = np.lexsort((-exposure, own))
        first = order[np.flatnonzero(np.diff(own[order], prepend=-1))]  # highest of each group
        better = first[exposure[first] > self.exposure[own[first]]]
        self.exposure[own[better]] = exposure[better]
        self.point[own[better]], self.instant[own[better]] = points[better], instants[better]
        self.top = max(self.top, float(exposure.max(initial=0.0)))


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
        found = self.peaks(F, np.zeros(len(self.bounds), dtype=np.int64), np.array([floor]), floor)
        return Peak(float(found.exposure[0]), int(found.point[0]), int(found.instant[0]))

    def peaks(self, F: Array, group: IntArray, floors: Array, top: float) -> Peaks:
        """Find the peak of every group of points under resultants F (6, t); see Peaks.

        Exact for groups whose peak is above their floor, and for the highest peak above `top`.
        """
        best = Peaks(group, floors, top)
        parts = np.maximum(np.concatenate([F, -F]), 0.0) * (1.0 + ROUND_OFF)
        starts = np.arange(0, F.shape[1], BLOCK)
        coarse = self.bounds @ np.maximum.reduceat(parts, starts, axis=1)  # (p, blocks)
        if not (coarse.max(axis=1) > best.level()[group]).any():
            return best
        # The point of the highest bound of each group, in the block of that bound.
        highest = coarse.max(axis=1)
        order = np.lexsort((-highest, group))
        lead = order[np.flatnonzero(np.diff(group[order], prepend=-1))]
        lead = lead[highest[lead] > best.level()[group[lead]]]
        self._look(F, lead, starts[np.argmax(coarse[lead], axis=1)], best, BLOCK)

        left = coarse > best.level()[group][:, None]
        points = np.flatnonzero(left.any(axis=1))
        if not len(points):
            return best
        instants = np.flatnonzero(np.repeat(left.any(axis=0), BLOCK)[: F.shape[1]])
        directions, parts, order = self._fan(F[:, instants], parts[:, instants])
        instants, starts = instants[order], np.arange(0, len(order), BLOCK)
        fan = self.criterion.bound(
            np.moveaxis(self.stress_M[points] @ directions, 2, 1), self.strength
        )
        upper = np.concatenate([self.bounds[points], fan], axis=1) @ np.maximum.reduceat(
            parts[:, order], starts, axis=1
        )
        # Evaluating each point where its bound is highest gives a level that few pairs exceed.
        self._look(F, points, instants[starts[np.argmax(upper, axis=1)]], best)
        row, blocks = np.nonzero(upper > best.level()[group[points]][:, None])
        own, of = upper[row, blocks], group[points[row]]
        ranked = np.argsort(-own / np.maximum(best.level()[of], 1e-300), kind="stable")
        for start in range(0, len(ranked), BATCH):
            batch = ranked[start : start + BATCH]
            batch = batch[own[batch] > best.level()[of[batch]]]
            if not batch.size:
                continue
            times = np.minimum(starts[blocks[batch]][:, None] + np.arange(BLOCK), len(order) - 1)
            self._look(F, np.repeat(points[row[batch]], BLOCK), instants[times.ravel()], best)
        return best

    def _fan(self, F: Array, parts: Array) -> tuple[Array, Array, IntArray]:
        """Return resultants of a fan of directions (6, FAN), and F as a sum of positive parts.

        The parts (12 + FAN, t) are those of the unit resultants and of the fan. Also returns the
        times (t,) by direction and size.
        """
        unit = self.bounds.max(axis=0).reshape(2, 6).max(axis=0)  # exposure of a unit resultant
        one, two = np.argsort(-unit * np.abs(F).max(axis=1), kind="stable")[:2].tolist()
        angle = 2.0 * np.pi / FAN * np.arange(FAN)
        directions = np.zeros((6, FAN))
        x, y = (F[k] * unit[k] for k in (one, two))
        for k, along in ((one, np.cos(angle)), (two, np.sin(angle))):
            directions[k] = along / unit[k] if unit[k] > 0.0 else 0.0
        sector = np.floor(np.arctan2(y, x) * (FAN / (2.0 * np.pi))).astype(np.int64) % FAN
        size, past = np.hypot(x, y), (np.arctan2(y, x) - angle[sector]) % (2.0 * np.pi)
        fine = sector * FINE + np.floor(past * (FINE / angle[1])).astype(np.int64)
        times, spread = np.arange(F.shape[1]), np.sin(angle[1])
        fan = np.zeros((FAN, F.shape[1]))
        fan[sector, times] = size * np.sin(angle[1] - past) / spread
        fan[(sector + 1) % FAN, times] = size * np.sin(past) / spread
        rest = parts.copy()
        rest[[one, two, one + 6, two + 6]] = 0.0
        fan = np.maximum(fan, 0.0) * (1.0 + ROUND_OFF)
        return directions, np.concatenate([rest, fan]), np.lexsort((-size, fine))

    def _look(
        self, F: Array, points: IntArray, instants: IntArray, best: Peaks, along: int = 1
    ) -> None:
        """Evaluate pairs of point and time, (k,) each, and as many times after it as `along`."""
        if along > 1:
            times = np.minimum(instants[:, None] + np.arange(along), F.shape[1] - 1)
            points, instants = np.repeat(points, along), times.ravel()
        stress = np.einsum("kij,jk->ki", self.stress_M[points], F[:, instants])
        best.take(self.criterion.assess(stress, self.strength).exposure, points, instants)
