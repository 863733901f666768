"""Checks of the laminates and cell resultants of a package, and whether they match the body."""

from collections.abc import Iterator

import numpy as np

from ...math.arrays import Array
from ..common.array_checks import finite, positive_definite, rotations, rows_of, symmetric
from ..common.remark import Remark, Reporter
from ..section.recovery_checks import check_plies
from ..shell.cells import area_vectors, cell_table
from .laminate_data import CellResultants, LaminateData
from .schema import ModalPackage

ENERGY = 2.0  # factor: strain energy of the mean resultants, which is less than the total
NORMAL = 1e-3  # sine of the angle between a cell's normal and its e3
EQUILIBRIUM = 1e-6  # relative error of the integrated stresses of a unit resultant
SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0  # quadrature over a ply, exact for quadratic stresses


def check_laminate(laminate: LaminateData, where: str, error: Reporter) -> None:
    """Report numbers of a laminate that cannot be used; `where` starts the path of its datasets."""
    faces = np.array([[ply.bottom, ply.top, ply.angle_deg] for ply in laminate.plies])
    values = {"plies/stress_M": laminate.stress_M, "ABD": laminate.ABD, "Ds": laminate.Ds}
    for path, array in {**values, "plies/bottom": faces}.items():
        finite(f"{where}{path}", array, error)
    if not all(np.isfinite(array).all() for array in (*values.values(), faces)):
        return
    for path in ("ABD", "Ds"):
        symmetric(f"{where}{path}", values[path], error)
        positive_definite(f"{where}{path}", values[path], error)
    if np.any(faces[:, 1] <= faces[:, 0]):
        row = int(np.argmax(faces[:, 1] <= faces[:, 0]))
        error(f"{where}plies/top", f"row {row}: expected a height above that of plies/bottom")
    check_plies(laminate, "laminate", where, error)


def check_cells(found: CellResultants, n_laminate: int, n_cell: int, error: Reporter) -> None:
    """Report resultants of cells that cannot be used."""
    for name in ("A_BE", "resultants_E"):
        finite(f"cell_resultants/{name}", getattr(found, name), error)
    rows_of("cell_resultants/cell", found.cell, n_cell, error)
    rows_of("cell_resultants/laminate", found.laminate, n_laminate, error)
    if np.isfinite(found.A_BE).all():
        rotations("cell_resultants/A_BE", found.A_BE, error)


def laminate_findings(package: ModalPackage) -> Iterator[Remark]:
    """Return suspicious findings about the stresses of a shell."""
    for laminate in package.laminates:
        yield from _equilibrium(laminate)
    if package.cell_resultants is not None:
        yield from _cells(package, package.cell_resultants)


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
    yield from _energy(package, found, area)


def _energy(package: ModalPackage, found: CellResultants, area: Array) -> Iterator[Remark]:
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
