"""Write and read a section file: HDF5, and a valid VTKHDF file (docs/section-file.md)."""

from pathlib import Path

import h5py
import numpy as np

from ..common.container import get_text, set_long_text
from ..common.dataset import read_datasets, write_datasets
from ..common.identity import json_table, json_text
from ..common.object_file import new_object_file, read_object_file
from ..common.remark import raise_first
from ..common.reported import warnings_from
from ..common.vtk_view import create_grid, describe, part_view, plane_view
from .checks import (
    check_shapes,
    section_content_findings,
    section_layout_findings,
    section_plausibility_findings,
)
from .layout import (
    SECTION_FILE,
    SECTION_FILE_LAYOUT,
    SECTION_GROUP,
    SECTION_VIEW,
    section_sizes,
    section_values,
)
from .recovery_data import recovery_from
from .schema import RESULTANTS, SectionFile, SectionMeshData
from .stress import cell_means, unit_stress

# VTK and ParaView name the six columns of a symmetric tensor xx, yy, zz, xy, yz, xz: ours
# are 11, 22, 33, 23, 13, 12, and x, y, z are x1, x2, x3.
VTK_TENSOR = (0, 1, 2, 5, 3, 4)


def write_section(path: str | Path, section: SectionFile) -> None:
    """Write a section file; it appears only when it is complete.

    Raises
    ------
    PackageError
        The section is inconsistent (shapes, NaN, symmetry, rows). The message names file and
        dataset; nothing is written.
    """
    path = Path(path)
    check_shapes(path, section)
    raise_first(path, section_content_findings(section))
    values = section_values(section, str(path))
    with new_object_file(path, SECTION_FILE, section.name, "a section file") as (file, group):
        set_long_text(file, "provenance", json_text(f"{path}: provenance", section.provenance))
        write_datasets(path, group, SECTION_FILE_LAYOUT, values, section_sizes(values))
        _write_view(file, group, section)


def read_section(path: str | Path) -> SectionFile:
    """Read a section file and check that its numbers can be used; see `read_object_file`."""
    return read_object_file(
        path,
        SECTION_FILE,
        section_layout_findings,
        load_section,
        section_content_findings,
        SECTION_VIEW,
        section_plausibility_findings,
    )


def load_section(file: h5py.File) -> SectionFile:
    """Read all arrays of a file with a checked layout."""
    group = file[SECTION_GROUP]
    data = read_datasets(group, SECTION_FILE_LAYOUT)
    mesh = {name: data[f"mesh/{name}"] for name in ("nodes", "connectivity", "offsets", "region")}
    mesh |= {name: data[f"mesh/{name}"] for name in ("regions", "ply", "layer_direction", "fibre")}
    return SectionFile(
        name=get_text(file, SECTION_FILE.title),
        K=data["K"],
        M=data["M"],
        error_estimate=data.get("error_estimate"),
        shear_centre=data["shear_centre"],
        tension_centre=data["tension_centre"],
        mass_centre=data["mass_centre"],
        mesh=SectionMeshData(cell_types=data["mesh/cell_types"].astype(np.int64), **mesh),
        warping=data["warping"],
        recovery=recovery_from(data, f"{file.filename}: {group.name}"),
        initial_curvature=data.get("initial_curvature"),
        end_compliance=data.get("end_compliance"),
        warnings=warnings_from(data),
        provenance=json_table(f"{file.filename}: provenance", get_text(file, "provenance", "{}")),
    )


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
