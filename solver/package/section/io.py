"""Write and read a section file: HDF5, and a valid VTKHDF file (docs/section-file.md)."""

from pathlib import Path

import h5py
import numpy as np

from ..common.object_file import ObjectFormat, read_object, write_object
from ..common.vtk_view import create_grid, describe, part_view, plane_view
from .checks import section_content_findings, section_plausibility_findings
from .schema import RESULTANTS, SECTION_FORMAT, SECTION_FORMAT_VERSION, SectionFile
from .stress import cell_means, unit_stress

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
