"""Write, read and check a section file: HDF5, and a valid VTKHDF file (docs/section-file.md)."""

from pathlib import Path

import h5py
import numpy as np

from ...errors import did_you_mean
from ...math.arrays import Array
from ..common.dataset import field_values
from ..common.findings import (
    Remark,
    Reporter,
    finite,
    mesh_cells,
    positive_definite,
    rows_of,
    symmetric,
)
from ..common.object_file import ObjectFormat, read_object, write_object
from ..common.recovery_schema import RESULTANTS
from ..common.vtk_view import create_grid, describe, part_view, plane_view
from .section_schema import SECTION_FORMAT, SECTION_FORMAT_VERSION, SectionFile
from .stress import cell_means, check_recovery, unit_resultants_findings, unit_stress

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


# VTK and ParaView name the six columns of a symmetric tensor xx, yy, zz, xy, yz, xz: ours
# are 11, 22, 33, 23, 13, 12, and x, y, z are x1, x2, x3.
VTK_TENSOR = (0, 1, 2, 5, 3, 4)


def _write_view(file: h5py.File, group: h5py.Group, section: SectionFile) -> None:
    """Add /VTKHDF: links to mesh and warping; only the angles and mean stresses are computed."""
    view = create_grid(file, group["mesh"], "nodes")
    cells = view.create_group("CellData")
    for name in ("region", "ply", "fibre"):
        cells[name] = group["mesh"][name]
    describe(plane_view(cells, "layer_direction", group["mesh/layer_direction"]), "-", "section")
    angles = np.array([ply.angle_deg for ply in section.recovery.plies])
    describe(cells.create_dataset("angle_deg", data=angles[section.mesh.ply]), "deg", "layer")
    points = view.create_group("PointData")
    warping = group["warping"]
    stress = cell_means(section, unit_stress(section.recovery))[:, VTK_TENSOR, :]
    for i, name in enumerate(RESULTANTS):
        moment = name.startswith("M")
        shown = part_view(points, f"warping_{name}", warping, np.s_[i, :, :], warping.shape[1:])
        describe(shown, "1/N" if moment else "m/N", "section")
        shown = cells.create_dataset(f"stress_{name}", data=stress[:, :, i])
        describe(shown, "1/m3" if moment else "1/m2", "section")


SECTION_FILE = ObjectFormat(
    SECTION_FORMAT,
    SECTION_FORMAT_VERSION,
    "section",
    "name",
    SectionFile,
    "a section file",
    "nodes",
    section_content_findings,
    _write_view,
    section_plausibility_findings,
)


def write_section(path: str | Path, section: SectionFile) -> None:
    """Write a section file; see `write_object`."""
    write_object(path, SECTION_FILE, section)


def read_section(path: str | Path) -> SectionFile:
    """Read a section file and check that its numbers can be used; see `read_object`."""
    return read_object(path, SECTION_FILE)
