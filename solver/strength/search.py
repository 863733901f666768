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

The envelope (highest exposure at every instant) uses the same bounds: at each instant, the point of
the highest bound is evaluated first, then every point whose bound is above what was found.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray, distinct
from ..package.common.materials import PlyStrength, YieldStrength
from . import Criterion, criteria_of

BLOCK = 16  # times per block
FAN = 16  # directions in the plane of the two largest resultants
FINE = 8  # of parts into which times between two of them are sorted
BATCH = 128  # pairs of point and block evaluated together
ROUND_OFF = 1e-12  # relative tolerance of a bound that equals the exposure


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
        """Take exposures of pairs of point and time, (k,) each.

        Parameters
        ----------
        exposure : exposures (k,)
        points : points (k,)
        instants : numbers of the times (k,)
        """
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

    @cached_property
    def bounds(self) -> Array:
        """Bounds of the exposure of each point by the positive parts of F and -F, (p, 12)."""
        unit = np.moveaxis(self.stress_M, 2, 1)  # (p, resultant, stress)
        return self.criterion.bound(np.concatenate([unit, -unit], axis=1), self.strength)

    def peaks(self, F: Array, group: IntArray, floors: Array, top: float) -> Peaks:
        """Find the peak of every group of points under resultants F (6, t); see Peaks.

        Exact for groups whose peak is above their floor, and for the highest peak above `top`.

        Parameters
        ----------
        F : resultants over time (6, t) [N, N m]
        group : group of each point (p,)
        floors : peaks below these are not needed (g,)
        top : highest exposure found before
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


FEW = 16  # points that are evaluated without bounds
AT_ONCE = 1_000_000  # numbers in memory at a time
LEADS = 8  # points that are evaluated at all instants


Place = tuple[Array, PeakSearch]  # resultants (6, m) of a station or (8, m) of a cell; its points


def envelope(places: Sequence[Place], q: Array) -> Array:
    """Highest exposure 1 / R of all points (t,) [-].

    Parameters
    ----------
    places : resultants per unit mode with the points to which they apply
    q : (t, m) modal coordinates
    """
    top = np.zeros(len(q))
    for resultants_E, search in _most_loaded_first(places, q):
        step = max(1, AT_ONCE // (6 * min(len(search.bounds), 1000)))
        for first in range(0, len(q), step):
            some = slice(first, first + step)
            raise_to_peaks(search, resultants_E @ q[some].T, top[some])
    return top


GOVERNS = 1e-9  # below the highest exposure, relative: round-off


def governing(places: Sequence[Place], q: Array, top: Array) -> tuple[IntArray, IntArray]:
    """Return the place and its point that have the highest exposure `top` (t,) at each time.

    Point -1: none has, as without load.

    Parameters
    ----------
    places : resultants per mode and search, of each place
    q : modal coordinates (t, m)
    top : highest exposure at each time (t,)
    """
    place, point = np.zeros(len(q), dtype=np.int64), np.full(len(q), -1)
    for number, (resultants_E, search) in enumerate(places):
        F = resultants_E @ q.T
        parts = np.maximum(np.concatenate([F, -F]), 0.0) * (1.0 + ROUND_OFF)
        live = np.flatnonzero((point < 0) & (search.bounds.max(axis=0) @ parts >= top))
        if not live.size:
            continue
        points, instants = np.nonzero(search.bounds @ parts[:, live] >= top[live])
        at = live[instants]
        there = _exposures(search, F, points, at) >= top[at] * (1.0 - GOVERNS)
        place[at[there]], point[at[there]] = number, points[there]
    return place, point


def exposures_at(places: Sequence[Place], held: tuple[IntArray, IntArray], q: Array) -> Array:
    """Return the exposure (t,) of the place and point of each time, see `governing`.

    Parameters
    ----------
    places : resultants per mode and search, of each place
    held : place and point at each time (t,)
    q : modal coordinates (t, m)
    """
    exposures = np.zeros(len(q))
    for number in distinct(held[0]).tolist():
        resultants_E, search = places[number]
        at = np.flatnonzero((held[0] == number) & (held[1] >= 0))
        F = resultants_E @ q[at].T
        exposures[at] = _exposures(search, F, held[1][at], np.arange(at.size))
    return exposures


def raise_to_peaks(search: PeakSearch, F: Array, top: Array) -> None:
    """Raise top (t,), in place, to the highest exposure under resultants F (6 or 8, t).

    Parameters
    ----------
    search : search of one place
    F : resultants over time (6 or 8, t)
    top : highest exposure at each time (t,), raised
    """
    parts = np.maximum(np.concatenate([F, -F]), 0.0) * (1.0 + ROUND_OFF)
    live = np.flatnonzero(search.bounds.max(axis=0) @ parts > top)
    if not live.size:
        return
    if len(search.bounds) <= FEW:
        for point in range(len(search.bounds)):
            exposures = _exposures(search, F, np.full(live.size, point), live)
            top[live] = np.maximum(top[live], exposures)
        return
    upper = search.bounds @ parts[:, live]  # (p, instants)
    lead = np.argmax(upper, axis=0)
    number, times = np.unique(lead, return_counts=True)
    for point in number[np.argsort(-times, kind="stable")[:LEADS]]:
        exposures = _exposures(search, F, np.full(live.size, point), live)
        top[live] = np.maximum(top[live], exposures)
    top[live] = np.maximum(top[live], _exposures(search, F, lead, live))
    points, instants = np.nonzero(upper > top[live])
    for first in range(0, points.size, AT_ONCE // 36):
        some = slice(first, first + AT_ONCE // 36)
        at = live[instants[some]]
        np.maximum.at(top, at, _exposures(search, F, points[some], at))


def _exposures(search: PeakSearch, F: Array, points: IntArray, instants: IntArray) -> Array:
    stress = np.einsum("kij,jk->ki", search.stress_M[points], F[:, instants])
    return search.criterion.assess(stress, search.strength).exposure


def _most_loaded_first(places: Sequence[Place], q: Array) -> list[Place]:
    largest = np.abs(q).max(axis=0, initial=0.0)
    severity = [
        search.bounds.max(axis=0).reshape(2, -1).max(axis=0) @ (np.abs(F) @ largest)
        for F, search in places
    ]
    return [places[k] for k in np.argsort(-np.array(severity), kind="stable")]


# The few points of a section that govern its strength in a run, from a sample of its resultants.
# A picture that evaluates the strength ratio at every time needs no others.

SAMPLES = 240  # resultants that the points are chosen from
KEPT = 24  # points that are all kept
STRESSES_AT_ONCE = 2**14  # stresses, so that what the criteria compute stays in the cache


class Points(NamedTuple):
    """Points of one section or laminate: stresses per unit resultant, ply, strength of it."""

    stress_M: Array  # (p, 6, j)
    ply: IntArray  # (p,)
    strengths: dict[int, PlyStrength | YieldStrength]  # by ply


def governing_points(points: Points, resultants_E: Array, q: Array) -> IntArray:
    """Rows of the points that have the highest exposure of any criterion at some site and time.

    Parameters
    ----------
    resultants_E : (s, j, m) per unit mode, of the sites that have these points
    q : (t, m) modal coordinates
    """
    own = np.flatnonzero(np.isin(points.ply, list(points.strengths)))
    count = len(q) * len(resultants_E)
    if len(own) <= KEPT or not count:
        return own
    chosen = distinct(np.linspace(0, count - 1, SAMPLES).round().astype(int))
    time, site = np.divmod(chosen, len(resultants_E))
    sample = np.einsum("njm,nm->nj", resultants_E[site], q[time])
    sample = sample[np.abs(sample).max(axis=1) > 0.0]
    kept = [own[:1]]
    for strength in dict.fromkeys(points.strengths.values()):
        plies = [ply for ply, each in points.strengths.items() if each == strength]
        rows = own[np.isin(points.ply[own], plies)]
        unit = np.moveaxis(points.stress_M[rows], 2, 0).reshape(sample.shape[1], -1)
        step = max(1, STRESSES_AT_ONCE // len(rows))
        for first in range(0, len(sample), step):
            stress = (sample[first : first + step] @ unit).reshape(-1, len(rows), 6)
            for criterion in criteria_of(strength):
                exposure = criterion.assess(stress, strength).exposure
                kept.append(rows[np.argmax(exposure, axis=1)])
    return distinct(np.concatenate(kept))
