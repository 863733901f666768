"""Whether the stresses of a body match its sections, laminates and modes."""

from collections.abc import Iterator

import numpy as np

from ...math.arrays import Array, is_positive_definite
from ..common.remark import Remark
from ..section.stress import unit_resultants_findings
from ..shell.cells import area_vectors, cell_table
from .schema import CellResultants, LaminateData, ModalPackage

# Factors: the strain energy of mean resultants is less than the total; that of a mode of a beam is
# taken from a few stations, without distributed terms.
ENERGY = 2.0
NORMAL = 1e-3  # sine of the angle between a cell's normal and its e3
EQUILIBRIUM = 1e-6  # relative error of the integrated stresses of a unit resultant
FEW_POINTS = 1e-3  # the same of a beam, at the few points that are kept
SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0  # quadrature over a ply, exact for quadratic stresses


def stress_findings(package: ModalPackage) -> Iterator[Remark]:
    """Return suspicious findings about stresses of beams and shells."""
    yield from _beam(package)
    for laminate in package.laminates:
        yield from _equilibrium(laminate)
    if package.cell_resultants is not None:
        yield from _cells(package, package.cell_resultants)


def _beam(package: ModalPackage) -> Iterator[Remark]:
    """Return suspicious findings about stresses: sections in other units or axes than the body."""
    if package.recovery is None and all(s.recovery is None for s in package.sections):
        return
    for section in package.sections:
        if not is_positive_definite(section.K):
            path = f"/modal_package/sections/{section.name}/K"
            yield Remark("warning", path, "not positive definite: inconsistent with stresses")
            return
    for section in package.sections:
        if section.recovery is not None:
            path = f"/modal_package/sections/{section.name}/recovery/strain_M"
            yield from unit_resultants_findings(path, section.K, section.recovery, FEW_POINTS)
    yield from _beam_energy(package)


def _beam_energy(package: ModalPackage) -> Iterator[Remark]:
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


def _equilibrium(laminate: LaminateData) -> Iterator[Remark]:
    """Stresses of unit resultants, rotated to laminate axes and integrated over the plies."""
    back = np.zeros((6, 8))
    for ply, operator in zip(laminate.plies, laminate.stress_M, strict=True):
        z = np.array([ply.bottom, 0.5 * (ply.bottom + ply.top), ply.top])
        weight = SIMPSON * (ply.top - ply.bottom)
        in_plane = _turn(ply.angle_deg) @ operator[:, (0, 1, 5)]
        back[:3] += np.einsum("l,lij->ij", weight, in_plane)
        back[3:] += np.einsum("l,l,lij->ij", weight, z, in_plane)
    scale = np.sqrt(np.diag(laminate.ABD))
    gap = np.abs(back[:, :6] - np.eye(6)) * scale[None, :] / scale[:, None]
    if gap.max() > EQUILIBRIUM:
        i, j = (int(v) for v in np.unravel_index(np.argmax(gap), gap.shape))
        text = (
            f"the stresses of unit resultant {j + 1} integrate to {back[i, j]:.6g} of resultant "
            f"{i + 1}, expected {float(i == j):g}"
        )
        path = f"/modal_package/laminates/{laminate.name}/plies/stress_M"
        yield Remark("warning", path, text)


def _turn(angle_deg: float) -> Array:
    """Matrix that rotates stresses 11, 22, 12 of a ply to laminate axes, (3, 3)."""
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array(
        [[c * c, s * s, -2.0 * c * s], [s * s, c * c, 2.0 * c * s], [c * s, -c * s, c * c - s * s]]
    )


def _cells(package: ModalPackage, found: CellResultants) -> Iterator[Remark]:
    where = "/modal_package/cell_resultants"
    offsets = package.offsets
    if not np.isin(np.diff(offsets)[found.cell], (3, 4)).all():
        text = "some of these cells are neither triangles nor quadrilaterals"
        yield Remark("warning", f"{where}/cell", text)
        return
    cells = cell_table(package.connectivity, offsets, found.cell)
    vector = area_vectors(package.nodes_B, cells)
    area = np.linalg.norm(vector, axis=1)
    e3 = found.A_BE[:, :, 2]
    off = np.linalg.norm(np.cross(vector, e3), axis=1) > NORMAL * area
    if off.any():
        text = f"row {int(np.argmax(off))}: e3 is not normal to the cell"
        yield Remark("warning", f"{where}/A_BE", text)
    yield from _cell_energy(package, found, area)


def _cell_energy(package: ModalPackage, found: CellResultants, area: Array) -> Iterator[Remark]:
    """The mean resultants of the cells cannot have more energy than the mode."""
    energy = np.zeros(package.n_mode)
    for row, laminate in enumerate(package.laminates):
        own = found.laminate == row
        S = np.zeros((8, 8))
        S[:6, :6], S[6:, 6:] = np.linalg.inv(laminate.ABD), np.linalg.inv(laminate.Ds)
        R = found.resultants_E[own]
        energy += np.einsum("cim,cim->m", R, area[own][:, None, None] * (S @ R))
    stiffness = np.diag(package.stiffness)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(stiffness > 0.0, energy / stiffness, 0.0)
    factor[[kind == "rigid" for kind in package.mode_kinds]] = 0.0  # both energies are round-off
    if package.n_mode and factor.max() > ENERGY:
        i = int(np.argmax(factor))
        text = f"mode {i + 1}: their strain energy is {factor[i]:.3g} times that of modes/stiffness"
        yield Remark("warning", "/modal_package/cell_resultants/resultants_E", text)
