"""Checks of a section file: shapes, numbers, plausibility."""

import numpy as np

from ...errors import did_you_mean
from ...math.arrays import Array
from ..common.array_checks import finite, mesh_cells, positive_definite, rows_of, symmetric
from ..common.dataset import field_values
from ..common.remark import Remark, Reporter
from .recovery_data import check_recovery
from .schema import SectionFile
from .stress import unit_resultants_findings

# Nodes of the plane cells that a section file may hold, by VTK cell type.
CELL_NODES = {5: 3, 9: 4, 22: 6, 23: 8, 28: 9}
UNIT = 1e-9  # deviation of a unit vector's length
EQUILIBRIUM = 1e-6  # relative: error of the integrated stresses of unit resultants


def section_content_findings(section: SectionFile) -> list[Remark]:
    """Check the numbers of a section with correct shapes."""
    bad: list[Remark] = []

    def error(dataset: str, message: str) -> None:
        bad.append(Remark("error", f"/section/{dataset}", message))

    for path, value in field_values(section).items():
        finite(path, value, error)
    if bad:
        return bad  # the other checks would report the same error
    for name, matrix in (("K", section.K), ("M", section.M)):
        symmetric(name, matrix, error)
        _definite(name, matrix, error)
    if section.end_compliance is not None:
        symmetric("end_compliance", section.end_compliance, error)
    if section.error_estimate is not None and np.min(section.error_estimate) < 0.0:
        error("error_estimate", "expected values >= 0: an error estimate has no sign")
    _mesh(section, error)
    _plies(section, error)
    _recovery(section, error)
    return bad


def section_plausibility_findings(section: SectionFile) -> list[Remark]:
    """Warn if the stresses of the unit resultants do not integrate to these resultants.

    Requires a section without errors in `section_content_findings`.
    """
    path = "/section/recovery/strain_M"
    return unit_resultants_findings(path, section.K, section.recovery, EQUILIBRIUM)


def _definite(path: str, matrix: Array, error: Reporter) -> None:
    """Report an entry of the diagonal that is not above 0, otherwise an eigenvalue that is not."""
    diagonal = np.diag(matrix)
    if not np.all(diagonal > 0.0):
        i = int(np.argmin(diagonal))
        error(path, f"expected a diagonal above 0, entry [{i}, {i}] is {diagonal[i]:.6g}")
        return
    positive_definite(path, matrix, error)


def _mesh(section: SectionFile, error: Reporter) -> None:
    mesh, plies = section.mesh, section.recovery.plies
    mesh_cells(mesh.offsets, mesh.connectivity, len(mesh.nodes), error)
    rows_of("mesh/region", mesh.region, len(mesh.regions), error)
    rows_of("mesh/ply", mesh.ply, len(plies), error)
    if len(set(mesh.regions)) != len(mesh.regions):
        error("mesh/regions", "expected unique names, some occur twice")
    sizes = np.diff(mesh.offsets)
    for row, kind in enumerate(np.asarray(mesh.cell_types).tolist()):
        if kind not in CELL_NODES:
            known = ", ".join(map(str, CELL_NODES))
            error("mesh/cell_types", f"expected one of {known}, cell {row} is {kind}")
            break
        if sizes[row] != CELL_NODES[kind]:
            text = f"cell {row} has {sizes[row]} nodes, its type {kind} has {CELL_NODES[kind]}"
            error("mesh/offsets", text)
            break
    for name in ("layer_direction", "fibre"):
        length = np.linalg.norm(getattr(mesh, name), axis=1)
        if np.any(np.abs(length - 1.0) > UNIT):
            row = int(np.argmax(np.abs(length - 1.0)))
            error(f"mesh/{name}", f"expected unit vectors, row {row} has length {length[row]:.9g}")


def _plies(section: SectionFile, error: Reporter) -> None:
    regions = section.mesh.regions
    for row, ply in enumerate(section.recovery.plies):
        if ply.region not in regions:
            hint = did_you_mean(ply.region, regions)
            error("plies/region", f"row {row}: {ply.region!r} is not a region of the section{hint}")
        if ply.index < 0:
            error("plies/index", f"expected 0, 1, ..., row {row} is {ply.index}")


def _recovery(section: SectionFile, error: Reporter) -> None:
    recovery, n_cell = section.recovery, len(section.mesh.cell_types)
    check_recovery(recovery, "", error)
    rows_of("recovery/cell", recovery.cell, n_cell, error)
    cells = np.asarray(recovery.cell)
    if not len(cells) or cells.min() < 0 or cells.max() >= n_cell:
        return
    area = np.bincount(cells, weights=recovery.weights, minlength=n_cell)
    if np.any(area <= 0.0):
        row = int(np.argmin(area))
        error("recovery/weights", f"expected an area above 0, that of cell {row} is {area[row]:g}")
