"""Can the recovery of a package be used, and does it belong to the body?"""

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np

from ..errors import did_you_mean
from .array_checks import finite, positive_definite, rotations, rows_of, symmetric
from .finding import Finding, Reporter
from .materials import MaterialError
from .recovery_data import POINT_DATA, OfMaterials, strengths
from .schema import BodyRecovery, ModalPackage, SectionData
from .section import RESULTANTS, SectionRecovery
from .section_stress import resultants, unit_stress

EQUILIBRIUM = 1e-3  # relative: what unit resultants integrate back to at the few points kept
ENERGY = 2.0  # factor: strain energy of a mode from a few stations, without distributed terms


def check_recovery(recovery: SectionRecovery, where: str, error: Reporter) -> None:
    """Report numbers of a recovery that cannot be used; `where` starts the path of its datasets."""
    arrays = {f"{where}recovery/{name}": getattr(recovery, name) for name in POINT_DATA}
    arrays[f"{where}plies/C_M"] = recovery.C_M
    for path, values in arrays.items():
        finite(path, values, error)
    if not all(np.isfinite(values).all() for values in arrays.values()):
        return
    rows_of(f"{where}recovery/ply", recovery.ply, len(recovery.plies), error)
    rotations(f"{where}recovery/A_BM", recovery.A_BM, error)
    for row, C_M in enumerate(recovery.C_M):
        symmetric(f"{where}plies/C_M[{row}]", C_M, error)
        positive_definite(f"{where}plies/C_M[{row}]", C_M, error)
    if not np.sum(recovery.weights) > 0.0:
        text = f"expected an area above 0, found {np.sum(recovery.weights):g} m2"
        error(f"{where}recovery/weights", text)
    check_plies(recovery, "section", where, error)


class OfPlies(OfMaterials, Protocol):
    """Whatever has plies, and their materials by name."""

    @property
    def plies(self) -> Sequence[Any]:
        """Each with the name of its `material`."""


def check_plies(owner: OfPlies, kind: str, where: str, error: Reporter) -> None:
    """Report plies of unknown materials, and strengths that cannot be used; `kind` is for words."""
    for row, ply in enumerate(owner.plies):
        if ply.material not in owner.materials:
            hint = did_you_mean(ply.material, tuple(owner.materials))
            text = f"row {row}: {ply.material!r} is no material of the {kind}{hint}"
            error(f"{where}plies/material", text)
    try:
        strengths(owner)
    except MaterialError as cause:
        error(f"{where}materials", str(cause))


def check_stations(recovery: BodyRecovery, n_section: int, error: Reporter) -> None:
    """Report stations of a body that cannot be used."""
    for name in ("station_x", "resultants_E", "A_BE"):
        finite(f"recovery/{name}", getattr(recovery, name), error)
    if np.any(np.diff(recovery.station_x) < 0.0):
        error("recovery/station_x", "expected places in rising order")
    rows_of("recovery/section", recovery.section, n_section, error)
    rotations("recovery/A_BE", recovery.A_BE, error)


def recovery_findings(package: ModalPackage) -> Iterator[Finding]:
    """Return what is suspicious about stresses: sections in other units or axes than the body's."""
    if package.recovery is None and all(s.recovery is None for s in package.sections):
        return
    for section in package.sections:
        scale = 1.0 / np.sqrt(np.maximum(np.diag(section.K), 1e-300))
        if not np.linalg.eigvalsh(section.K * np.outer(scale, scale))[0] > 0.0:
            path = f"/modal_package/sections/{section.name}/K"
            yield Finding("warning", path, "not positive definite: stresses cannot belong to it")
            return
    for section in package.sections:
        yield from _equilibrium(section)
    yield from _energy(package)


def _equilibrium(section: SectionData) -> Iterator[Finding]:
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
        yield Finding("warning", path, text)


def _energy(package: ModalPackage) -> Iterator[Finding]:
    """Compare F6' K^-1 F6 along the beam with the modal stiffness.

    Not of attachment modes: what they are made of between a few stations, and the shear that a
    classical beam leaves out, are no small part of their energy.
    """
    found = package.recovery
    if found is None or not package.n_mode:
        return
    S = np.array([np.linalg.inv(section.K) for section in package.sections])[found.section]
    density = np.einsum("sam,sab,sbm->sm", found.resultants_E, S, found.resultants_E)
    lengths = np.diff(found.station_x)[:, None]
    energy = np.sum(0.5 * lengths * (density[:-1] + density[1:]), axis=0)
    stiffness = np.diag(package.stiffness)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(stiffness > 0.0, energy / stiffness, 1.0)
    static = np.array([kind == "attachment" for kind in package.mode_kinds])
    wrong = np.flatnonzero(~static & ((factor > ENERGY) | (factor < 1.0 / ENERGY)))
    if wrong.size:
        i = int(wrong[0])
        text = f"mode {i + 1}: their strain energy is {factor[i]:.3g} times that of modes/stiffness"
        yield Finding("warning", "/modal_package/recovery/resultants_E", text)
