"""The highest stresses and the strength ratios of every ply under given resultants."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array
from ...package.section.corners import near_corner, reentrant_corners
from ...package.section.recovery_data import strengths
from ...package.section.schema import Ply, SectionFile, SectionMeshData, SectionRecovery
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


def ply_peaks(
    recovery: SectionRecovery, F: Array, left_out: NDArray[np.bool_] | None = None
) -> list[PlyPeak]:
    """Peak stresses and reserves of all plies, in their order.

    Parameters
    ----------
    F : (6,) F1, F2, F3, M1, M2, M3 at the reference point [N, N m]
    left_out : (p,) True for points that are not judged; absent: none

    Raises
    ------
    MaterialError : a table of strengths that cannot be used.
    """
    stress_M = unit_stress_M(recovery) @ np.asarray(F, dtype=float)
    known = strengths(recovery)
    judged = np.ones(len(recovery.ply), dtype=bool) if left_out is None else ~left_out
    peaks = []
    for row, ply in enumerate(recovery.plies):
        points = np.flatnonzero(judged & (recovery.ply == row))
        if not len(points):
            continue  # thinner than the distance between the points, or left out
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


def weakest(peaks: Sequence[PlyPeak]) -> dict[str, PlyPeak]:
    """The ply with the least margin by each criterion, of the plies that it judges."""
    found: dict[str, PlyPeak] = {}
    for peak in peaks:
        for name, reserve in peak.reserves.items():
            if name not in found or reserve.ratio < found[name].reserves[name].ratio:
                found[name] = peak
    return found


def judged_peaks(
    section: SectionFile, F: Array, distance: float | None
) -> tuple[list[PlyPeak], list[dict[str, str]]]:
    """`ply_peaks` of a section, and warnings about the places of the least margins.

    distance : from re-entrant corners [m], below which points are not judged; absent: all are
    """
    recovery, mesh = section.recovery, section.mesh
    if distance is None:
        peaks = ply_peaks(recovery, F)
        return peaks, corner_warnings(mesh, peaks)
    left_out = near_corner(mesh, recovery.points, distance)
    return ply_peaks(recovery, F, left_out), []


def corner_warnings(mesh: SectionMeshData, peaks: list[PlyPeak]) -> list[dict[str, str]]:
    """Warning if least margins lie in cells at re-entrant corners: they depend on the mesh."""
    nodes, sizes = reentrant_corners(mesh)
    if not len(nodes):
        return []
    found = []
    for name, peak in weakest(peaks).items():
        reserve = peak.reserves[name]
        away = np.linalg.norm(mesh.nodes[nodes] - reserve.point, axis=1)
        nearest = int(np.argmin(away))
        if away[nearest] < sizes[nearest]:
            found.append((reserve.ratio, away[nearest], nodes[nearest], name))
    if not found:
        return []
    _, away_least, node, _ = min(found)
    x2, x3 = mesh.nodes[node]
    names = [name for *_, name in found]
    least = (
        f"the least margins by {', '.join(names)} lie"
        if names[1:]
        else f"the least margin by {names[0]} lies"
    )
    return [
        {
            "code": "stress-at-corner",
            "message": f"{least} at a re-entrant corner, the worst {away_least:.3g} m from "
            f"({x2:.4g}, {x3:.4g}): a finer mesh gives a smaller one; choose a distance with "
            "--corner-distance",
        }
    ]
