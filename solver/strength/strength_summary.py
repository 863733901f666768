"""What the search for the lowest strength ratio of a body found, for summary, report, warnings."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..math.arrays import Array
from ..math.records import record
from ..package.common.materials import PlyStrength, YieldStrength
from ..package.common.recovery_schema import STRESSES, Ply
from . import Criterion, criteria_of
from .search import PeakSearch


class Reserve(NamedTuple):
    """Factor on all loads at which a criterion predicts failure, and the place of the failure."""

    ratio: float  # strength ratio R; margin of safety R - 1          [-]
    criterion: str
    mode: str
    place: Any


def least_reserves(
    stress_M: Array, strength: PlyStrength | YieldStrength | None, place_of: Callable[[int], Any]
) -> list[Reserve]:
    """Return the least reserve of stresses (p, 6) by each criterion; none without strengths.

    Parameters
    ----------
    stress_M : in the axes of the material [Pa]
    strength : of the material, if it has any
    place_of : place of a row of the stresses
    """
    criteria = () if strength is None else criteria_of(strength)
    return [_reserve(criterion, strength, stress_M, place_of) for criterion in criteria]


def _reserve(
    criterion: Criterion, strength: Any, stress_M: Array, place_of: Callable[[int], Any]
) -> Reserve:
    verdict = criterion.assess(stress_M, strength)
    row = int(np.argmax(verdict.exposure))
    mode = verdict.modes[int(verdict.mode[row])]
    return Reserve(float(verdict.ratio[row]), criterion.name, mode, place_of(row))


@record
class CriticalPoint:
    """The highest exposure so far of a ply under a criterion."""

    exposure: float
    search: PeakSearch
    row: int  # of the search
    F: Array  # (6,) or (8,) resultants, of a solid stresses
    time: float  # [s]
    x: float  # station along the body [m]
    point: Array  # (2,) x2, x3 in the section; of a shell (3,) body axes [m]
    place: str  # description of the point within the station
    ply: Ply

    @property
    def stress_M(self) -> Array:
        """Stresses (6,) in ply axes, order 11 22 33 23 13 12 [Pa]."""
        return np.asarray(self.search.stress_M[self.row] @ self.F)

    @cached_property
    def reserve(self) -> Reserve:
        """What the criterion says of them."""
        criterion, strength = self.search.criterion, self.search.strength
        return _reserve(criterion, strength, self.stress_M[None], lambda _: self.place)

    @property
    def ratio(self) -> float:
        """Strength ratio R."""
        return self.reserve.ratio


class BodyStrength(NamedTuple):
    """Exposures of a body over a run; `s` counts stations of a beam, strips of a shell."""

    station_x: Array  # (s,) positions along the body                           [m]
    exposure: dict[str, Array]  # (s,) highest 1 / R by criterion     [-]
    worst: dict[str, CriticalPoint]  # by criterion
    plies: tuple[CriticalPoint, ...]  # of each, the lowest of all criteria; the weakest first

    @property
    def governing(self) -> CriticalPoint:
        """The lowest strength ratio of all criteria."""
        return max(self.worst.values(), key=lambda peak: peak.exposure)


def ranked(
    station_x: Array, exposure: dict[str, Array], peaks: Mapping[tuple[Ply, str], CriticalPoint]
) -> BodyStrength | None:
    """Put together what was found of each ply by each criterion; None without any.

    Parameters
    ----------
    station_x, exposure : see BodyStrength
    peaks : by ply and name of the criterion
    """
    worst: dict[str, CriticalPoint] = {}
    weakest: dict[Ply, CriticalPoint] = {}
    for (ply, name), peak in peaks.items():
        if name not in worst or peak.exposure > worst[name].exposure:
            worst[name] = peak
        if ply not in weakest or peak.exposure > weakest[ply].exposure:
            weakest[ply] = peak
    if not worst:
        return None
    plies = tuple(sorted(weakest.values(), key=lambda peak: -peak.exposure))
    return BodyStrength(
        station_x, exposure, {name: worst[name] for name in exposure if name in worst}, plies
    )


def summary(strength: BodyStrength) -> dict[str, object]:
    """The entry of a body in summary.json."""
    worst = strength.governing
    return {
        **_entry(worst),
        "stress": {"unit": "Pa", **dict(zip(STRESSES, worst.stress_M.tolist(), strict=True))},
        "criteria": {name: _entry(each) for name, each in strength.worst.items()},
        "plies": [_entry(each) for each in strength.plies],
        "along_beam": {
            "x": strength.station_x.tolist(),
            "exposure": {name: values.tolist() for name, values in strength.exposure.items()},
        },
    }


def failure_text(body: str, peak: CriticalPoint) -> str:
    """Message of the warning about a ply that fails."""
    reserve, ply = peak.reserve, peak.ply
    return (
        f"{body}: {reserve.criterion} gives a strength ratio of {reserve.ratio:.3g} (expected "
        f"above 1; {reserve.mode}) at x = {peak.x:.4g} m, t = {peak.time:.4g} s, in ply "
        f"{ply.index} of {ply.region} ({ply.material}, {ply.angle_deg:g} deg) at {peak.place}: "
        "the linear material model is not valid beyond; use a stronger lay-up or a lower load"
    )


def _entry(peak: CriticalPoint) -> dict[str, object]:
    return {
        "ratio": peak.ratio,
        "margin": peak.ratio - 1.0,
        "criterion": peak.reserve.criterion,
        "mode": peak.reserve.mode,
        "x": peak.x,
        "time": peak.time,
        "ply": asdict(peak.ply),
        "point": peak.point.tolist(),
    }
