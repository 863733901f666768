"""Resultants and ply stresses at a position along a flexible body."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..errors import InputError, few, nearest
from ..math.arrays import Array, IntArray
from ..mechanism import BuiltMechanism
from ..package import ModalPackage
from ..package.body.schema import BodyRecovery
from ..package.section.schema import RESULTANTS, STRESSES, Ply, SectionRecovery
from ..strength.beam_bodies import unit_stress_M
from ..strength.fatigue import StressLife, check_rainflow
from .cut import equilibrium_resultants

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import PlyStressSignal, ResultantSignal


Values = Callable[[Recording], Array]
Look = Callable[[Recording], None]


def resultant_values(
    key: str, built: BuiltMechanism, body: int, package: ModalPackage, signal: "ResultantSignal"
) -> Values:
    """Return what gives a resultant (k,) [N or N m].

    Raises
    ------
    InputError
        A package without resultants, a position outside its stations; `key` is that of the case.
    """
    _, forces = _forces(key, built, body, package, signal)
    row = RESULTANTS.index(signal.component)
    return lambda recording: forces(recording)[:, row]


def ply_stress_values(
    key: str, built: BuiltMechanism, body: int, package: ModalPackage, signal: "PlyStressSignal"
) -> tuple[Values, Look]:
    """Return what gives a stress (k,) in ply axes [Pa], and what looks at all times before.

    Raises
    ------
    InputError
        See `resultant_values`; also a section without stresses, or an unknown region or ply.
    """
    section, forces = _forces(key, built, body, package, signal)
    recovery = package.sections[section].recovery
    if recovery is None:
        name = package.sections[section].name
        raise InputError(f"{key}: section {name} of {package.body} has no recovery of stresses")
    points = _points(key, recovery, signal)
    component = STRESSES.index(signal.component)
    rows = unit_stress_M(recovery)[points, component]  # (p, 6)

    own = object()

    def look(recording: Recording) -> None:
        highest = np.abs(forces(recording) @ rows.T).max(axis=0)
        recording.memory[own] = np.maximum(recording.memory.get(own, 0.0), highest)

    def values(recording: Recording) -> Array:
        if own not in recording.memory:
            look(recording)
        return forces(recording) @ rows[int(np.argmax(recording.memory[own]))]

    return values, look


def _forces(
    key: str,
    built: BuiltMechanism,
    body: int,
    package: ModalPackage,
    signal: "ResultantSignal | PlyStressSignal",
) -> tuple[int, Values]:
    """Return the section at x, and what gives the resultants (k, 6) there."""
    section, at = resultants_at(key, package, signal.x)
    if signal.method == "equilibrium":
        return section, equilibrium_resultants(key, built, body, package, signal.x)
    own = object()
    return section, lambda recording: recording.once(own, lambda: recording.modes(body) @ at.T)


def resultants_at(key: str, package: ModalPackage, x: float) -> tuple[int, Array]:
    """Return the section at x and the resultants (6, m) there per unit mode.

    They are linear between stations. If two stations have the same position, those of the far
    side are used.

    Raises
    ------
    InputError
        A package without resultants, a position outside its stations; `key` is that of the case.
    """
    recovery: BodyRecovery | None = package.recovery
    if recovery is None:
        raise InputError(f"{key}: the package of {package.body} has no recovery of resultants")
    stations = recovery.station_x
    if not stations[0] - 1e-9 <= x <= stations[-1] + 1e-9:
        raise InputError(
            f"{key}.x = {x:g}: expected {stations[0]:g} to {stations[-1]:g} m, the stations of "
            f"{package.body}"
        )
    last = int(np.searchsorted(stations, x + 1e-9, side="right")) - 1
    last = min(max(last, 0), len(stations) - 2)
    gap = stations[last + 1] - stations[last]
    share = min(max((x - stations[last]) / gap, 0.0), 1.0) if gap > 0.0 else 1.0
    F = recovery.resultants_E
    return int(recovery.section[last]), (1.0 - share) * F[last] + share * F[last + 1]


def _points(key: str, recovery: SectionRecovery, signal: "PlyStressSignal") -> IntArray:
    """Return the rows of the points of a ply: all, or the one nearest to `point`."""
    regions = list(dict.fromkeys(ply.region for ply in recovery.plies))
    region = signal.region
    if region is None:
        if len(regions) > 1:
            raise InputError(f"{key}.region: missing; expected one of {few(regions)}")
        region = regions[0]
    if region not in regions:
        raise InputError(f'{key}.region = "{region}": no such region{nearest(region, regions)}')
    numbers = {p.index: k for k, p in enumerate(recovery.plies) if p.region == region}
    if signal.ply not in numbers:
        raise InputError(
            f"{key}.ply = {signal.ply}: expected 0 to {max(numbers)}, the plies of {region}"
        )
    points = np.flatnonzero(recovery.ply == numbers[signal.ply])
    if signal.point is not None:
        away = np.linalg.norm(recovery.points[points] - np.array(signal.point), axis=1)
        points = points[[int(np.argmin(away))]]
    return points


if TYPE_CHECKING:
    from ..inputs.case.tables.signals import PlyStressSignal
    from ..inputs.common.materials import IsotropicMaterial, OrthotropicMaterial

    Materials = Mapping[str, IsotropicMaterial | OrthotropicMaterial]

_LINES = {"11": "fibre", "22": "transverse", "33": "transverse"}


def stress_life(
    materials: "Materials", package: ModalPackage, signal: "PlyStressSignal"
) -> StressLife | None:
    """Return the S-N line of a stress; None if the case has none for it.

    Raises
    ------
    InputError
        Cycles cannot be counted: a package is missing.
    """
    plies = [
        ply for section in package.sections if section.recovery for ply in section.recovery.plies
    ]
    named = {ply.material for ply in plies if _is_of(ply, signal)}
    for name in sorted(named & set(materials)):
        material, line = materials[name], None
        if material.kind == "isotropic":
            line = material.fatigue
        elif material.fatigue is not None:
            line = getattr(material.fatigue, _LINES.get(signal.component, "shear"))
        if line is not None:
            check_rainflow(f"materials.{name}.fatigue")
            return StressLife(
                np.array(line.amplitude),
                np.array(line.cycles),
                line.ultimate or np.inf,
                line.limit or 0.0,
            )
    return None


def _is_of(ply: Ply, signal: "PlyStressSignal") -> bool:
    return ply.index == signal.ply and signal.region in (None, ply.region)
