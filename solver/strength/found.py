"""What the search for the lowest strength ratio of a body found, for summary, report, warnings."""

from collections.abc import Mapping
from dataclasses import dataclass

from ..math.arrays import Array
from ..package.section.section_schema import STRESSES, Ply
from .search import PeakSearch


@dataclass(frozen=True)
class Failure:
    """Position, time and mode of the highest exposure of a body, or of one of its plies."""

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
class CriticalPoint:
    """The highest exposure so far of a ply under a criterion."""

    exposure: float
    search: PeakSearch
    point: int  # of the search
    F: Array  # (6,) or (8,) resultants, of a solid stresses
    time: float  # [s]
    x: float  # station along the body [m]
    at: Array  # Failure.point
    place: str
    ply: Ply

    def failure(self) -> Failure:
        """Return the verdict of the criterion there."""
        stress_M = self.search.stress_M[self.point] @ self.F
        verdict = self.search.criterion.assess(stress_M, self.search.strength)
        return Failure(
            criterion=self.search.criterion.name,
            mode=verdict.modes[int(verdict.mode)],
            ratio=float(verdict.ratio),
            index=float(verdict.index),
            x=self.x,
            point=self.at,
            ply=self.ply,
            time=self.time,
            stress_M=stress_M,
            place=self.place,
        )


@dataclass(frozen=True)
class BodyStrength:
    """Exposures of a body over a run; `s` counts stations of a beam, strips of a shell."""

    station_x: Array  # (s,) positions along the body                           [m]
    exposure: dict[str, Array]  # (s,) highest 1 / R by criterion     [-]
    worst: dict[str, Failure]  # by criterion
    plies: tuple[Failure, ...]  # of every ply, the lowest ratio of all criteria; the weakest first

    @property
    def governing(self) -> Failure:
        """The lowest strength ratio of all criteria."""
        return min(self.worst.values(), key=lambda failure: failure.ratio)


def ranked(
    station_x: Array, exposure: dict[str, Array], peaks: Mapping[tuple[Ply, str], CriticalPoint]
) -> BodyStrength | None:
    """Put together what was found of each ply by each criterion; None without any.

    Parameters
    ----------
    station_x, exposure : see BodyStrength
    peaks : by ply and name of the criterion
    """
    worst: dict[str, Failure] = {}
    weakest: dict[Ply, Failure] = {}
    for (ply, name), peak in peaks.items():
        failure = peak.failure()
        if name not in worst or failure.ratio < worst[name].ratio:
            worst[name] = failure
        if ply not in weakest or failure.ratio < weakest[ply].ratio:
            weakest[ply] = failure
    if not worst:
        return None
    plies = tuple(sorted(weakest.values(), key=lambda failure: failure.ratio))
    return BodyStrength(
        station_x, exposure, {name: worst[name] for name in exposure if name in worst}, plies
    )


def summary(strength: BodyStrength) -> dict[str, object]:
    """The entry of a body in summary.json."""
    failure = strength.governing
    return {
        **_entry(failure),
        "stress": {
            "unit": "Pa",
            **dict(zip(STRESSES, map(float, failure.stress_M), strict=True)),
        },
        "criteria": {name: _entry(each) for name, each in strength.worst.items()},
        "plies": [_entry(each) for each in strength.plies],
        "along_beam": {
            "x": strength.station_x.tolist(),
            "exposure": {name: values.tolist() for name, values in strength.exposure.items()},
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


def _entry(failure: Failure) -> dict[str, object]:
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
