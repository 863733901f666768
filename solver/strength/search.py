"""Search for the points and times of highest exposure of a section under many resultants.

Exposures are proportional to the stress, and the stress of a point is linear in the six
resultants. A convex bound u of the exposure therefore obeys the triangle inequality,

    exposure(F) <= u(F) <= sum_j  F_j+ u(e_j) + F_j- u(-e_j),   F_j+, F_j- >= 0,

with u(e_j) of each point under each unit resultant computed once per section. The two resultants
that matter most are written in the two nearest of `FAN` directions of their plane instead: the
bound is then at most a few per cent too high.

The largest u of a group of points (a ply) bounds the group, which excludes most groups at most
times. Where the bounds are highest, the criterion is evaluated first. Then it is evaluated wherever
a bound is above the exposure found. The result is therefore exact.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray, distinct
from ..package.common.materials import PlyStrength, YieldStrength
from . import Criterion, criteria_of

FAN = 16  # directions in the plane of the two largest resultants
ROUND_OFF = 1e-12  # relative tolerance of a bound that equals the exposure
AT_ONCE = 1_000_000  # numbers in memory at a time


class Highest:
    """The highest exposure of each of some sets, and its point and column of resultants.

    Attributes
    ----------
    exposure : (s,) at the start those that are not of interest; raised in place
    point, column : (s,) -1: none is higher
    """

    def __init__(self, exposure: Array) -> None:
        self.exposure = exposure
        self.point, self.column = np.full((2, exposure.size), -1)

    def take(self, own: IntArray, exposure: Array, points: IntArray, columns: IntArray) -> None:
        """Take exposures (k,) of sets `own` (k,).

        Parameters
        ----------
        own : set of each exposure (k,)
        exposure : exposures (k,)
        points, columns : where they are (k,)
        """
        order = np.lexsort((-exposure, own))
        first = order[np.flatnonzero(np.diff(own[order], prepend=-1))]  # highest of each set
        first = first[exposure[first] > self.exposure[own[first]]]
        self.exposure[own[first]] = exposure[first]
        self.point[own[first]], self.column[own[first]] = points[first], columns[first]


class PeakSearch:
    """The search prepared for the points of one material.

    Parameters
    ----------
    stress_M : (p, 6, r) stress of each point in its ply axes per unit resultant [Pa/N, Pa/(N m)]
    criterion, strength : failure criterion and strengths of the material
    group : (p,) group of each point, 0 to g - 1; None: one
    """

    def __init__(
        self, stress_M: Array, criterion: Criterion, strength: Any, group: IntArray | None = None
    ) -> None:
        self.stress_M = stress_M
        self.criterion, self.strength = criterion, strength
        self.group = np.zeros(len(stress_M), dtype=np.int64) if group is None else group
        self.members = [np.flatnonzero(self.group == g) for g in range(self.group.max() + 1)]

    @cached_property
    def bounds(self) -> Array:
        """Bounds of the exposure of each point by the positive parts of F and -F, (p, 2 r)."""
        unit = np.moveaxis(self.stress_M, 2, 1)  # (p, resultant, stress)
        return self.criterion.bound(np.concatenate([unit, -unit], axis=1), self.strength)

    def peaks(self, F: Array, case: IntArray, groups: Highest, cases: Highest) -> None:
        """Raise exposures of groups and of cases to the highest of resultants F (r, n).

        What is below the exposure of its group and of its case before is not of interest.

        Parameters
        ----------
        F : resultants (r, n) [N, N m]
        case : case of each column, as its station (n,)
        groups : of the groups of points (g,)
        cases : of the cases (c,)
        """
        largest = max(len(self.members) + FAN + 4 * len(F), *map(len, self.members))
        step = max(1, AT_ONCE // largest)
        for first in range(0, F.shape[1], step):
            some = slice(first, first + step)
            self._raise(F[:, some], case[some], first, groups, cases)

    def _raise(self, F: Array, case: IntArray, first: int, groups: Highest, cases: Highest) -> None:
        parts = np.maximum(np.concatenate([F, -F]), 0.0) * (1.0 + ROUND_OFF)

        def level() -> Array:  # (g, n)
            return np.minimum(groups.exposure[:, None], cases.exposure[case])

        live = np.flatnonzero((self._of_groups(self.bounds) @ parts > level()).any(axis=0))
        if not live.size:
            return
        F, case = F[:, live], case[live]
        directions, parts = self._fan(F, parts[:, live])
        fan = self.criterion.bound(np.moveaxis(self.stress_M @ directions, 2, 1), self.strength)
        bounds = np.concatenate([self.bounds, fan], axis=1)
        upper = self._of_groups(bounds) @ parts

        def look(group: IntArray, column: IntArray, least: Array | None) -> None:
            """Evaluate points whose bound is above the least; None: that of the highest."""
            points, columns = [], []
            for g in distinct(group):
                at = column[group == g]
                own = bounds[self.members[g]] @ parts[:, at]
                if least is None:
                    row, k = np.argmax(own, axis=0), np.arange(at.size)
                else:
                    row, k = np.nonzero(own > least[g, at])
                points.append(self.members[g][row])
                columns.append(at[k])
            point, column = np.concatenate(points), np.concatenate(columns)
            for start in range(0, point.size, AT_ONCE // 36):
                p, k = (x[start : start + AT_ONCE // 36] for x in (point, column))
                exposure = self.exposures(F, p, k)
                groups.take(self.group[p], exposure, p, first + live[k])
                cases.take(case[k], exposure, p, first + live[k])

        # The highest bound of each group, and that of each case: few exposures are above these.
        order = np.lexsort((-upper.max(axis=0), case))
        lead = order[np.flatnonzero(np.diff(case[order], prepend=-1))]
        group = np.concatenate([np.arange(len(upper)), np.argmax(upper[:, lead], axis=0)])
        lead = np.concatenate([np.argmax(upper, axis=1), lead])
        look(group, lead, None)
        least = level()
        group, left = np.nonzero(upper > least)
        if left.size:
            look(group, left, least)

    def exposures(self, F: Array, points: IntArray, columns: IntArray) -> Array:
        """Evaluate the criterion at pairs of point and column, (k,) [-].

        Parameters
        ----------
        F : (r, n) resultants
        points : (k,) rows of the points of the search
        columns : (k,) columns of F
        """
        stress = np.einsum("kij,jk->ki", self.stress_M[points], F[:, columns])
        return self.criterion.assess(stress, self.strength).exposure

    def _of_groups(self, bounds: Array) -> Array:
        """Return the highest bounds of each group."""
        return np.array([bounds[rows].max(axis=0) for rows in self.members])

    def _fan(self, F: Array, parts: Array) -> tuple[Array, Array]:
        """Return resultants of a fan of f directions (r, f), and F as a sum of positive parts.

        The parts (2 r + f, n) are those of the unit resultants and of the fan.
        """
        unit = self.bounds.max(axis=0).reshape(2, -1).max(axis=0)  # exposure of a unit resultant
        one, two = np.argsort(-unit * np.abs(F).max(axis=1), kind="stable")[:2].tolist()
        x, y = (F[k] * unit[k] for k in (one, two))
        spread, columns = 2.0 * np.pi / FAN, np.arange(F.shape[1])
        sector, past = np.divmod(np.arctan2(y, x) % (2.0 * np.pi), spread)
        near = (sector.astype(np.int64) + np.array([[0], [1]])) % FAN
        used, near = np.unique(near, return_inverse=True)
        near = near.reshape(2, -1)
        directions = np.zeros((len(F), used.size))
        for k, along in ((one, np.cos(used * spread)), (two, np.sin(used * spread))):
            directions[k] = along / unit[k] if unit[k] > 0.0 else 0.0
        fan, size = np.zeros((used.size, F.shape[1])), np.hypot(x, y) / np.sin(spread)
        fan[near[0], columns] = size * np.sin(spread - past)
        fan[near[1], columns] = size * np.sin(past)
        rest = parts.copy()
        rest[[one, two, one + len(F), two + len(F)]] = 0.0
        return directions, np.concatenate([rest, np.maximum(fan, 0.0) * (1.0 + ROUND_OFF)])


Place = tuple[Array, PeakSearch]  # resultants (6, m) of a station or (8, m) of a cell; its points


def envelope(places: Sequence[Place], q: Array) -> tuple[Array, tuple[IntArray, IntArray]]:
    """Highest exposure 1 / R of all points (t,) [-], and the places and points that have it.

    Point -1: none has, as without load.

    Parameters
    ----------
    places : resultants per unit mode with the points to which they apply
    q : (t, m) modal coordinates
    """
    top, place = Highest(np.zeros(len(q))), np.zeros(len(q), dtype=np.int64)
    of_search: dict[PeakSearch, list[int]] = {}
    for number, (_, search) in enumerate(places):
        of_search.setdefault(search, []).append(number)
    for search, numbers in of_search.items():
        step = max(1, AT_ONCE // (6 * len(q)))
        for first in range(0, len(numbers), step):
            some = numbers[first : first + step]
            F = np.concatenate([places[k][0] @ q.T for k in some], axis=1)
            top.column[:] = -1
            groups = Highest(np.full(len(search.members), np.inf))
            search.peaks(F, np.tile(np.arange(len(q)), len(some)), groups, top)
            new = np.flatnonzero(top.column >= 0)
            place[new] = np.array(some)[top.column[new] // len(q)]
    return top.exposure, (place, top.point)


def exposures_at(places: Sequence[Place], held: tuple[IntArray, IntArray], q: Array) -> Array:
    """Return the exposure (t,) of the place and point of each time, see `envelope`.

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
        exposures[at] = search.exposures(F, held[1][at], np.arange(at.size))
    return exposures


# The few points of a section that govern its strength in a run, from a sample of its resultants.
# A picture that evaluates the strength ratio at every time needs no others.

SAMPLES = 240  # resultants that the points are chosen from
KEPT = 24  # points that are all kept


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
    if not points.strengths:
        return np.zeros(0, dtype=np.int64)
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
        group = np.unique(points.ply[rows], return_inverse=True)[1]
        for criterion in criteria_of(strength):
            search = PeakSearch(points.stress_M[rows], criterion, strength, group)
            top = Highest(np.zeros(len(sample)))
            search.peaks(
                sample.T, np.arange(len(sample)), Highest(np.full(len(plies), np.inf)), top
            )
            kept.append(rows[top.point[top.point >= 0]])
    return distinct(np.concatenate(kept))
