"""Ply stresses and strength ratios of a body from its modal coordinates.

The package has the resultants of every mode at stations along the beam and, for each section,
the strain of its points per unit resultant. A stress is therefore C_M strain_M resultants_E q. Its
accuracy depends on the modes. The quasi-static response of omitted modes (to a load close to a
support, to a concentrated mass on a short beam) is missing in the stress. This error is larger than
that of the motion; more modes reduce it.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray
from ..package.body.package_schema import BodyRecovery, ModalPackage
from ..package.common.materials import PlyStrength, YieldStrength
from ..package.common.recovery_schema import Ply, SectionRecovery
from ..package.section.stress import strengths
from . import Criterion, criteria_of
from .found import BodyStrength, CriticalPoint, ranked
from .search import Highest, PeakSearch


def resultants(package: ModalPackage, q: Array) -> Array:
    """Resultants at the stations of a package, section axes, (s, 6, t) [N, N m].

    q : (t, m) modal coordinates. Raises ValueError if the package has no recovery.
    """
    return np.asarray(_recovery(package).resultants_E @ q.T)


def unit_stress_M(recovery: SectionRecovery, points: IntArray | slice = slice(None)) -> Array:
    """Stress of points in their ply axes per unit resultant, (p, 6, 6) [Pa/N, Pa/(N m)]."""
    return np.asarray(recovery.C_M[recovery.ply[points]] @ recovery.strain_M[points])


def beam_search(package: ModalPackage) -> "BeamSearch | None":
    """Return the search of a beam; None without recovery or without strengths."""
    if package.recovery is None or not package.n_mode:
        return None
    search = BeamSearch(package)
    return search if search.exposure else None


class MaterialSearch(NamedTuple):
    """The points of one material of a section under one criterion."""

    criterion: Criterion
    strength: PlyStrength | YieldStrength
    recovery: SectionRecovery
    points: IntArray  # rows of the recovery's points
    plies: IntArray  # (g,) rows of the recovery's plies that have points
    peaks: PeakSearch


def material_searches(
    recovery: SectionRecovery, points: IntArray | None = None, criteria: tuple[str, ...] = ()
) -> Iterator[MaterialSearch]:
    """Yield the searches of a section.

    Parameters
    ----------
    points : rows of the recovery's points; absent: all
    criteria : names of those to be used; none given: all
    """
    material = np.array([ply.material for ply in recovery.plies])
    chosen = np.arange(len(recovery.ply)) if points is None else points
    for name, strength in strengths(recovery).items():
        own = chosen[(material == name)[recovery.ply[chosen]]]
        if not own.size:
            continue
        stress_M = unit_stress_M(recovery, own)
        plies, group = np.unique(recovery.ply[own], return_inverse=True)
        for criterion in criteria_of(strength):
            if not criteria or criterion.name in criteria:
                peaks = PeakSearch(stress_M, criterion, strength, group)
                yield MaterialSearch(criterion, strength, recovery, own, plies, peaks)


class BeamSearch:
    """The lowest strength ratio of every ply of a beam, over blocks of times."""

    def __init__(self, package: ModalPackage) -> None:
        self._package, self._stations = package, _recovery(package)
        self._searches = [
            (np.flatnonzero(self._stations.section == row), search)
            for row, section in enumerate(package.sections)
            if section.recovery is not None
            for search in material_searches(section.recovery)
        ]
        n = len(self._stations.station_x)
        criteria = {search.criterion for _, search in self._searches}
        names = sorted(criteria, key=lambda c: (c.order, c.name))
        self.exposure = {criterion.name: np.zeros(n) for criterion in names}
        self._highest: dict[Ply, float] = {}  # by all criteria
        self._peaks: dict[tuple[Ply, str], CriticalPoint] = {}

    def take(self, t: Array, q: Array) -> None:
        """Look at times t (k,) with modal coordinates q (k, m)."""
        F = np.moveaxis(resultants(self._package, q), 1, 0)  # (6, s, k)
        for stations, search in self._searches:
            if stations.size:
                self._look(search, stations, t, F[:, stations].reshape(len(F), -1))

    def _look(self, search: MaterialSearch, stations: IntArray, t: Array, F: Array) -> None:
        name, plies = search.criterion.name, search.recovery.plies
        groups = Highest(np.array([self._highest.get(plies[ply], 0.0) for ply in search.plies]))
        cases = Highest(self.exposure[name][stations])
        search.peaks.peaks(F, np.repeat(np.arange(stations.size), t.size), groups, cases)
        self.exposure[name][stations] = cases.exposure
        found = [*zip(groups.exposure, groups.point, groups.column, strict=True)]
        found += [(0.0, rows[0], 0) for rows in search.peaks.members]  # of plies without a peak
        top = int(np.argmax(cases.exposure))
        found.append((cases.exposure[top], cases.point[top], cases.column[top]))
        for exposure, point, column in found:
            row = search.points[point]
            ply, (x2, x3) = plies[search.recovery.ply[row]], search.recovery.points[row]
            peak = self._peaks.get((ply, name))
            if point < 0 or (peak is not None and peak.exposure >= exposure):
                continue
            self._highest[ply] = max(self._highest.get(ply, 0.0), float(exposure))
            self._peaks[ply, name] = CriticalPoint(
                float(exposure),
                search.peaks,
                int(point),
                F[:, column].copy(),
                float(t[column % t.size]),
                float(self._stations.station_x[stations[column // t.size]]),
                search.recovery.points[row],
                f"x2 = {x2:.4g} m, x3 = {x3:.4g} m",
                ply,
            )

    def found(self) -> BodyStrength | None:
        """Return what was found so far."""
        plied = [k for k, each in enumerate(self._package.sections) if each.recovery is not None]
        there = np.isin(self._stations.section, plied)
        exposure = {name: values[there] for name, values in self.exposure.items()}
        return ranked(self._stations.station_x[there], exposure, self._peaks)


def _recovery(package: ModalPackage) -> BodyRecovery:
    if package.recovery is None:
        raise ValueError(f"{package.body}: the package has no recovery of resultants")
    return package.recovery
