"""Strength ratio of plies over time: of one point, a ply, a station or a whole body."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.analysis.recovery import HELD, Recording
from ..errors import InputError, nearest
from ..math.arrays import Array, IntArray
from ..package import ModalPackage
from ..package.body.package_schema import CellResultants, LaminateData
from ..package.common.recovery_schema import SectionRecovery
from ..strength.search import Place, envelope, exposures_at
from ..strength.weakest_plies import cell_centres, material_searches, ply_searches, stressed_cells
from .sections import resultants_at

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import StrengthSignal


def strength_values(
    key: str, body: int, package: ModalPackage, signal: "StrengthSignal"
) -> Callable[[Recording], Array]:
    """Return what gives strength ratio or exposure (k,) [-].

    Parameters
    ----------
    key : key of the case file, for messages
    body : number of the body
    package : its modal package
    signal : table of the signal

    Raises
    ------
    InputError
        A package without resultants or strengths, an unknown region, ply or criterion; `key` is
        that of the case.
    """
    criteria = () if signal.criterion is None else (signal.criterion,)
    cells, laminates = stressed_cells(package)
    if cells is not None:
        places = _of_shell(key, package, cells, laminates, signal, criteria)
    else:
        places = _of_beam(key, package, signal, criteria)
    if not places:
        raise InputError(
            f"{key}: no material of these plies of {package.body} has strengths"
            + (f" for {signal.criterion}" if signal.criterion else "")
        )

    def exposure(recording: Recording) -> Array:
        q, held = recording.modes(body), recording.memory.get(HELD)
        if held is None:
            return envelope(places, q)[0]
        if (key, body) in held:
            return exposures_at(places, held[key, body], q)
        top, held[key, body] = envelope(places, q)
        return top

    if signal.kind == "exposure":
        return exposure

    def ratio(recording: Recording) -> Array:
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(1.0 / exposure(recording))

    return ratio


def _of_beam(
    key: str, package: ModalPackage, signal: "StrengthSignal", criteria: tuple[str, ...]
) -> list[Place]:
    if package.recovery is None:
        raise InputError(f"{key}: the package of {package.body} has no recovery of resultants")
    if signal.x is not None:
        section, F = resultants_at(key, package, signal.x)
        stations = [(section, F)]
    else:
        rows = package.recovery.section
        stations = list(zip(map(int, rows), package.recovery.resultants_E, strict=True))
    recoveries = {
        row: recovery
        for row in {row for row, _ in stations}
        if (recovery := package.sections[row].recovery) is not None
    }
    _check_point(key, signal, 2)
    plies = [ply for recovery in recoveries.values() for ply in recovery.plies]
    regions = [ply.region for ply in plies]
    numbers = [ply.index for ply in plies if signal.region in (None, ply.region)]
    _check_ply(key, package, signal, regions, numbers)
    searches = {
        row: tuple(material_searches(recovery, _points(recovery, signal), criteria))
        for row, recovery in recoveries.items()
    }
    return [(F, search.peaks) for row, F in stations for search in searches.get(row, ())]


def _points(recovery: SectionRecovery, signal: "StrengthSignal") -> IntArray:
    """Return the rows of the points of a section that are looked at."""
    wanted = [
        k
        for k, ply in enumerate(recovery.plies)
        if signal.region in (None, ply.region) and signal.ply in (None, ply.index)
    ]
    points = np.flatnonzero(np.isin(recovery.ply, wanted))
    if signal.point is not None and points.size:
        away = np.linalg.norm(recovery.points[points] - np.array(signal.point), axis=1)
        points = points[[int(np.argmin(away))]]
    return points


def _of_shell(
    key: str,
    package: ModalPackage,
    cells: CellResultants,
    laminates: tuple[LaminateData, ...],
    signal: "StrengthSignal",
    criteria: tuple[str, ...],
) -> list[Place]:
    _check_point(key, signal, 3)
    regions = [laminate.name for laminate in laminates]
    numbers = [
        k
        for laminate in laminates
        if signal.region in (None, laminate.name)
        for k in range(len(laminate.plies))
    ]
    _check_ply(key, package, signal, regions, numbers)
    rows = np.flatnonzero([signal.region in (None, regions[k]) for k in cells.laminate])
    if signal.point is not None and rows.size:
        away = np.linalg.norm(cell_centres(package, cells)[rows] - np.array(signal.point), axis=1)
        rows = rows[[int(np.argmin(away))]]
    searches = []
    for laminate in laminates:
        plies = [k for k in range(len(laminate.plies)) if signal.ply in (None, k)]
        searches.append([peaks for _, peaks in ply_searches(laminate, plies, criteria)])
    return [
        (cells.resultants_E[row], peaks)
        for row in rows
        for peaks in searches[int(cells.laminate[row])]
    ]


def _check_ply(
    key: str,
    package: ModalPackage,
    signal: "StrengthSignal",
    regions: list[str],
    numbers: list[int],
) -> None:
    """Refuse regions and plies that a package does not have."""
    if not regions:
        raise InputError(f"{key}: the package of {package.body} has no recovery of stresses")
    if signal.region is not None and signal.region not in regions:
        known = list(dict.fromkeys(regions))
        raise InputError(
            f'{key}.region = "{signal.region}": no such region{nearest(signal.region, known)}'
        )
    if signal.ply is not None and signal.ply not in numbers:
        where = signal.region or package.body
        raise InputError(
            f"{key}.ply = {signal.ply}: expected 0 to {max(numbers)}, the plies of {where}"
        )


def _check_point(key: str, signal: "StrengthSignal", expected: int) -> None:
    """Refuse points that do not fit the kind of body; check.py does not know packages."""
    if signal.point is not None and len(signal.point) != expected:
        what = "x2, x3 of a beam" if expected == 2 else "x, y, z of a shell or solid"
        raise InputError(f"{key}.point = {signal.point}: expected {expected} numbers, {what}")
    if signal.x is not None and expected == 3:
        raise InputError(f"{key}.x = {signal.x:g}: expected for beams only, the body is none")
