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
from .search import PeakSearch


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
    plies: IntArray  # rows of the recovery's plies that have points
    group: IntArray  # (p,) of each point, as row of `plies`
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
    material = np.array([ply.material for ply in recovery.plies])[recovery.ply]
    chosen = np.arange(len(material)) if points is None else points
    for name, strength in strengths(recovery).items():
        own = chosen[material[chosen] == name]
        if not own.size:
            continue
        stress_M = unit_stress_M(recovery, own)
        plies, group = np.unique(recovery.ply[own], return_inverse=True)
        for criterion in criteria_of(strength):
            if not criteria or criterion.name in criteria:
                peaks = PeakSearch(stress_M, criterion, strength)
                yield MaterialSearch(criterion, strength, recovery, own, plies, group, peaks)


class BeamSearch:
    """The lowest strength ratio of every ply of a beam, over blocks of times."""

    def __init__(self, package: ModalPackage) -> None:
        self._package, self._stations = package, _recovery(package)
        self._searches = {
            row: tuple(material_searches(section.recovery))
            for row, section in enumerate(package.sections)
            if section.recovery is not None
        }
        every = [search for own in self._searches.values() for search in own]
        n = len(self._stations.station_x)
        names = sorted({s.criterion for s in every}, key=lambda c: (c.order, c.name))
        self.exposure = {criterion.name: np.zeros(n) for criterion in names}
        # Exposure of a unit resultant, to compare stations with each other.
        units = [s.peaks.bounds.max(axis=0).reshape(2, 6).max(axis=0) for s in every]
        self._severity = np.max(units, axis=0) if units else np.zeros(6)
        self._peaks: dict[tuple[Ply, str], CriticalPoint] = {}

    def take(self, t: Array, q: Array) -> None:
        """Look at times t (k,) with modal coordinates q (k, m)."""
        F = resultants(self._package, q)
        # From the most loaded station on: its peaks leave little to look for at the others.
        for station in np.argsort(-np.abs(F).max(axis=2) @ self._severity, kind="stable").tolist():
            for search in self._searches.get(int(self._stations.section[station]), ()):
                self._look(search, station, t, F[station])

    def _look(self, search: MaterialSearch, station: int, t: Array, F: Array) -> None:
        name, plies = search.criterion.name, search.recovery.plies
        along = self.exposure[name]
        keys = [(plies[ply], name) for ply in search.plies]
        known = [self._peaks.get(key) for key in keys]
        floors = np.array([0.0 if peak is None else peak.exposure for peak in known])
        peaks = search.peaks.peaks(F, search.group, floors, float(along[station]))
        along[station] = peaks.top
        for g, peak in enumerate(known):
            if peak is None or peaks.exposure[g] > peak.exposure:
                instant, point = int(peaks.instant[g]), int(peaks.point[g])
                row = int(search.points[point])
                x2, x3 = at = search.recovery.points[row]
                self._peaks[keys[g]] = CriticalPoint(
                    float(peaks.exposure[g]),
                    search.peaks,
                    point,
                    F[:, instant].copy(),
                    float(t[instant]),
                    float(self._stations.station_x[station]),
                    at,
                    f"x2 = {x2:.4g} m, x3 = {x3:.4g} m",
                    search.recovery.plies[int(search.recovery.ply[row])],
                )

    def found(self) -> BodyStrength | None:
        """Return what was found so far."""
        there = np.isin(self._stations.section, list(self._searches))  # others have no plies
        exposure = {name: values[there] for name, values in self.exposure.items()}
        return ranked(self._stations.station_x[there], exposure, self._peaks)


def _recovery(package: ModalPackage) -> BodyRecovery:
    if package.recovery is None:
        raise ValueError(f"{package.body}: the package has no recovery of resultants")
    return package.recovery
