"""Ply stresses and strength ratios of a body from its modal coordinates.

The package has the resultants of every mode at stations along the beam and, for each section,
the strain of its points per unit resultant. A stress is therefore C_M strain_M resultants_E q. Its
accuracy depends on the modes. The quasi-static response of omitted modes (to a load close to a
support, to a concentrated mass on a short beam) is missing in the stress. This error is larger than
that of the motion; more modes reduce it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..math.arrays import Array, IntArray
from ..package.body.schema import BodyRecovery, ModalPackage
from ..package.common.strengths import PlyStrength, YieldStrength
from ..package.section.recovery_data import strengths
from ..package.section.schema import STRESSES, Ply, SectionRecovery
from . import Criterion, Verdict, criteria_of
from .search import PeakSearch


@dataclass(frozen=True)
class Failure:
    """Position, time and mode of the highest exposure of a body."""

    criterion: str
    mode: str
    ratio: float  # strength ratio R; margin of safety R - 1          [-]
    index: float  # value of the criterion, 1 at failure              [-]
    x: float  # station along the beam                                [m]
    point: Array  # (2,) x2, x3 in the section; of a shell (3,) body axes [m]
    ply: Ply
    time: float  # [s]
    stress_M: Array  # (6,) in ply axes, order 11 22 33 23 13 12      [Pa]
    place: str  # description of the point within the station


@dataclass(frozen=True)
class BodyStrength:
    """Exposures of a body over a run; `s` counts stations of a beam, strips of a shell."""

    station_x: Array  # (s,) positions along the body                           [m]
    exposure: dict[str, Array]  # (s,) highest 1 / R by criterion     [-]
    worst: dict[str, Failure]  # by criterion

    @property
    def governing(self) -> Failure:
        """The lowest strength ratio of all criteria."""
        return min(self.worst.values(), key=lambda failure: failure.ratio)


def resultants(package: ModalPackage, q: Array) -> Array:
    """Resultants at the stations of a package, section axes, (s, 6, t) [N, N m].

    q : (t, m) modal coordinates. Raises ValueError if the package has no recovery.
    """
    return np.asarray(_recovery(package).resultants_E @ q.T)


def unit_stress_M(recovery: SectionRecovery) -> Array:
    """Stress of each point in its ply axes per unit resultant, (p, 6, 6) [Pa/N, Pa/(N m)]."""
    return np.asarray(recovery.C_M[recovery.ply] @ recovery.strain_M)


def body_strength(package: ModalPackage, t: Array, q: Array) -> BodyStrength | None:
    """Find the lowest strength ratio of a body; None without recovery or without strengths.

    Parameters
    ----------
    t, q : (t,) times [s] and (t, m) modal coordinates at these
    """
    if package.recovery is None or not package.n_mode:
        return None
    searches = {
        row: list(_searches(section.recovery))
        for row, section in enumerate(package.sections)
        if section.recovery is not None
    }
    F = resultants(package, q)
    exposure: dict[str, Array] = {}
    places: dict[str, tuple[int, _Search, int, int]] = {}
    for station, row in enumerate(package.recovery.section):
        for search in searches.get(int(row), []):
            name = search.criterion.name
            along = exposure.setdefault(name, np.zeros(len(F)))
            peak = search.peaks.peak(F[station], floor=float(along[station]))
            if name not in places or peak.exposure > along.max():
                places[name] = (station, search, peak.point, peak.instant)
            along[station] = max(along[station], peak.exposure)
    worst = {
        name: _failure(package, t, F[station][:, instant], station, search, point, instant)
        for name, (station, search, point, instant) in places.items()
    }
    return BodyStrength(package.recovery.station_x, exposure, worst) if worst else None


def summary(found: BodyStrength) -> dict[str, Any]:
    """The entry of a body in summary.json."""
    failure = found.governing
    return {
        **_entry(failure),
        "stress": {
            "unit": "Pa",
            **dict(zip(STRESSES, map(float, failure.stress_M), strict=True)),
        },
        "criteria": {name: _entry(each) for name, each in found.worst.items()},
        "along_beam": {
            "x": found.station_x.tolist(),
            "exposure": {name: values.tolist() for name, values in found.exposure.items()},
        },
    }


def failure_text(body: str, failure: Failure) -> str:
    """Message of the warning about a ply that fails."""
    return (
        f"{body}: {failure.criterion} gives a strength ratio of {failure.ratio:.3g} (expected "
        f"above 1; {failure.mode}) at x = {failure.x:.4g} m, t = {failure.time:.4g} s, in ply "
        f"{failure.ply.index} of {failure.ply.region} ({failure.ply.material}, "
        f"{failure.ply.angle_deg:g} deg) at {failure.place}: the linear material model "
        "is not valid beyond; use a stronger lay-up or a lower load"
    )


@dataclass(frozen=True)
class _Search:
    """The points of one material of a section under one criterion."""

    criterion: Criterion
    strength: PlyStrength | YieldStrength
    recovery: SectionRecovery
    points: IntArray  # rows of the recovery's points
    peaks: PeakSearch


def _recovery(package: ModalPackage) -> BodyRecovery:
    if package.recovery is None:
        raise ValueError(f"{package.body}: the package has no recovery of resultants")
    return package.recovery


def _searches(recovery: SectionRecovery) -> Iterator[_Search]:
    stress_M = unit_stress_M(recovery)
    material = np.array([ply.material for ply in recovery.plies])[recovery.ply]
    for name, strength in strengths(recovery).items():
        points = np.flatnonzero(material == name)
        if not points.size:
            continue
        for criterion in criteria_of(strength):
            peaks = PeakSearch(stress_M[points], criterion, strength)
            yield _Search(criterion, strength, recovery, points, peaks)


def _failure(
    package: ModalPackage,
    t: Array,
    F: Array,
    station: int,
    search: _Search,
    point: int,
    instant: int,
) -> Failure:
    stress_M = search.peaks.stress_M[point] @ F
    verdict: Verdict = search.criterion.assess(stress_M, search.strength)
    row = int(search.points[point])
    x2, x3 = search.recovery.points[row]
    return Failure(
        criterion=search.criterion.name,
        mode=verdict.modes[int(verdict.mode)],
        ratio=float(verdict.ratio),
        index=float(verdict.index),
        x=float(_recovery(package).station_x[station]),
        point=search.recovery.points[row],
        ply=search.recovery.plies[int(search.recovery.ply[row])],
        time=float(t[instant]),
        stress_M=stress_M,
        place=f"x2 = {x2:.4g} m, x3 = {x3:.4g} m",
    )


def _entry(failure: Failure) -> dict[str, Any]:
    return {
        "ratio": failure.ratio,
        "margin": failure.ratio - 1.0,
        "criterion": failure.criterion,
        "mode": failure.mode,
        "x": failure.x,
        "time": failure.time,
        "ply": {
            "region": failure.ply.region,
            "index": failure.ply.index,
            "material": failure.ply.material,
            "angle_deg": failure.ply.angle_deg,
        },
        "point": failure.point.tolist(),
    }
