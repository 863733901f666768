"""The highest stresses and the strength ratios of every ply under given resultants."""

from dataclasses import dataclass

import numpy as np

from ...math.arrays import Array
from ...package.section.recovery_data import strengths
from ...package.section.schema import Ply, SectionRecovery
from ...strength import criteria_of
from ...strength.beam_bodies import unit_stress_M


@dataclass(frozen=True)
class Reserve:
    """Factor on all resultants at which a criterion predicts failure."""

    ratio: float  # strength ratio R; margin of safety R - 1    [-]
    mode: str
    point: tuple[float, float]  # x2, x3 of the first failure   [m]


@dataclass(frozen=True)
class PlyPeak:
    """One ply: its highest stresses, and the first failure by each criterion."""

    ply: Ply
    stress_M: Array  # (6,) of largest size, with sign: 11, 22, 33, 23, 13, 12 [Pa]
    reserves: dict[str, Reserve]  # by criterion; empty without strengths


def ply_peaks(recovery: SectionRecovery, F: Array) -> list[PlyPeak]:
    """Peak stresses and reserves of all plies, in their order.

    Parameters
    ----------
    F : (6,) F1, F2, F3, M1, M2, M3 at the reference point [N, N m]

    Raises
    ------
    MaterialError : a table of strengths that cannot be used.
    """
    stress_M = unit_stress_M(recovery) @ np.asarray(F, dtype=float)
    known = strengths(recovery)
    peaks = []
    for row, ply in enumerate(recovery.plies):
        points = np.flatnonzero(recovery.ply == row)
        if not len(points):
            continue  # thinner than the distance between the points
        own = stress_M[points]
        largest = own[np.argmax(np.abs(own), axis=0), np.arange(6)]
        reserves = {}
        if ply.material in known:
            strength = known[ply.material]
            for criterion in criteria_of(strength):
                verdict = criterion.assess(own, strength)
                worst = int(np.argmax(verdict.exposure))
                x2, x3 = recovery.points[points[worst]]
                mode = verdict.modes[int(verdict.mode[worst])]
                ratio = float(verdict.ratio[worst])
                reserves[criterion.name] = Reserve(ratio, mode, (float(x2), float(x3)))
        peaks.append(PlyPeak(ply, largest, reserves))
    return peaks
