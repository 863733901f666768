"""Checks of the recovery of a body: its stations, and whether stresses match its modes."""

from collections.abc import Iterator

import numpy as np

from ...math.definite import is_positive_definite
from ..common.array_checks import finite, rotations, rows_of
from ..common.remark import Remark, Reporter
from ..section.schema import RESULTANTS
from ..section.stress import resultants, unit_stress
from .schema import BodyRecovery, ModalPackage, SectionData

EQUILIBRIUM = 1e-3  # relative error of integrated unit resultants at the few kept points
ENERGY = 2.0  # factor: strain energy of a mode from a few stations, without distributed terms


def check_stations(recovery: BodyRecovery, n_section: int, error: Reporter) -> None:
    """Report stations of a body that cannot be used."""
    for name in ("station_x", "resultants_E", "A_BE"):
        finite(f"recovery/{name}", getattr(recovery, name), error)
    if np.any(np.diff(recovery.station_x) < 0.0):
        error("recovery/station_x", "expected positions in ascending order")
    rows_of("recovery/section", recovery.section, n_section, error)
    rotations("recovery/A_BE", recovery.A_BE, error)


def recovery_findings(package: ModalPackage) -> Iterator[Remark]:
    """Return suspicious findings about stresses: sections in other units or axes than the body."""
    if package.recovery is None and all(s.recovery is None for s in package.sections):
        return
    for section in package.sections:
        if not is_positive_definite(section.K):
            path = f"/modal_package/sections/{section.name}/K"
            yield Remark("warning", path, "not positive definite: inconsistent with stresses")
            return
    for section in package.sections:
        yield from _equilibrium(section)
    yield from _energy(package)


def _equilibrium(section: SectionData) -> Iterator[Remark]:
    if section.recovery is None:
        return
    scale = np.sqrt(np.diag(section.K))
    back = resultants(section.recovery, unit_stress(section.recovery))
    gap = np.abs(back - np.eye(6)) * scale[None, :] / scale[:, None]
    if gap.max() > EQUILIBRIUM:
        i, j = (int(v) for v in np.unravel_index(np.argmax(gap), gap.shape))
        text = (
            f"the stresses of a unit {RESULTANTS[j]} integrate to {RESULTANTS[i]} = "
            f"{back[i, j]:.6g}, expected {float(i == j):g}"
        )
        path = f"/modal_package/sections/{section.name}/recovery/strain_M"
        yield Remark("warning", path, text)


def _energy(package: ModalPackage) -> Iterator[Remark]:
    """Compare F6' K^-1 F6 along the beam with the modal stiffness.

    Attachment modes are excluded: their change between a few stations, and the shear that a
    classical beam neglects, are a considerable part of their energy. Rigid motions are excluded
    too: their energy is round-off.
    """
    found = package.recovery
    if found is None or not package.n_mode:
        return
    S = np.array([np.linalg.inv(section.K) for section in package.sections])[found.section]
    density = (found.resultants_E * (S @ found.resultants_E)).sum(axis=1)
    lengths = np.diff(found.station_x)[:, None]
    energy = np.sum(0.5 * lengths * (density[:-1] + density[1:]), axis=0)
    stiffness = np.diag(package.stiffness)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(stiffness > 0.0, energy / stiffness, 1.0)
    left_out = np.array([kind in ("attachment", "rigid") for kind in package.mode_kinds])
    wrong = np.flatnonzero(~left_out & ((factor > ENERGY) | (factor < 1.0 / ENERGY)))
    if wrong.size:
        i = int(wrong[0])
        text = f"mode {i + 1}: their strain energy is {factor[i]:.3g} times that of modes/stiffness"
        yield Remark("warning", "/modal_package/recovery/resultants_E", text)
