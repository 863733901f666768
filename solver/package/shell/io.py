"""Write and read a shell results file: HDF5, and a valid VTKHDF file."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..common.container import get_text, set_long_text
from ..common.dataset import read_datasets, write_datasets
from ..common.identity import json_table, json_text
from ..common.object_file import new_object_file, read_object_file
from ..common.remark import raise_first
from ..common.reported import warnings_from
from ..common.vtk_view import create_grid, describe, part_view
from .cells import cell_table
from .checks import check_shell_shapes, shell_content_findings, shell_layout_findings
from .layout import (
    BUCKLING,
    CASES,
    SHELL_FILE,
    SHELL_GROUP,
    SHELL_LAYOUT,
    SHELL_VIEW,
    shell_sizes,
    shell_values,
)
from .schema import (
    ShellBuckling,
    ShellCases,
    ShellFile,
    ShellLaminate,
    ShellMeshData,
    ShellModes,
    ShellPlaces,
    ShellPly,
    ShellProbes,
)

PARTS = (("N", slice(0, 3), "N/m"), ("M", slice(3, 6), "N"), ("T", slice(6, 8), "N/m"))


def write_shell(path: str | Path, shell: ShellFile) -> None:
    """Write a shell results file; it appears only when it is complete.

    Raises
    ------
    PackageError
        The shell is inconsistent (shapes, NaN, rows). The message names file and dataset; nothing
        is written.
    """
    path = Path(path)
    check_shell_shapes(path, shell)
    raise_first(path, shell_content_findings(shell))
    values = shell_values(shell, str(path))
    with new_object_file(path, SHELL_FILE, shell.name, "a shell file") as (file, group):
        set_long_text(file, "provenance", json_text(f"{path}: provenance", shell.provenance))
        write_datasets(path, group, SHELL_LAYOUT, values, shell_sizes(values))
        _write_view(file, group, shell)


def read_shell(path: str | Path) -> ShellFile:
    """Read a shell results file and check that its numbers can be used; see `read_object_file`."""
    return read_object_file(
        path, SHELL_FILE, shell_layout_findings, _load, shell_content_findings, SHELL_VIEW
    )


def _load(file: h5py.File) -> ShellFile:
    group, where = file[SHELL_GROUP], file.filename
    data = read_datasets(group, SHELL_LAYOUT)
    names = ("nodes_G", "node_ids", "region", "regions", "laminate", "A_GE", "area")
    modes = None
    if "modes/frequencies" in data:
        modes = ShellModes(
            data["modes/frequencies"],
            data["modes/shapes_G"],
            data["modes/resultants_E"],
            int(data["modes/n_zero"]),
            data.get("modes/error"),
        )
    return ShellFile(
        name=get_text(file, SHELL_FILE.title),
        mesh=ShellMeshData(
            cells=cell_table(data["mesh/connectivity"], data["mesh/offsets"]),
            **{name: data[f"mesh/{name}"] for name in names},
        ),
        laminates=_laminates(data, where),
        materials=json_table(f"{where}: materials", data["materials"]),
        supports=ShellPlaces(data["supports/names"], data["supports/points_G"]),
        links=ShellPlaces(data["links/names"], data["links/points_G"], data["links/kinds"]),
        cases=ShellCases(
            **{name: data[f"cases/{name}"] for name in (*CASES, "energy", "residual")}
        ),
        probes=ShellProbes(data["probes/names"], data["probes/quantities"], data["probes/values"]),
        modes=modes,
        buckling=ShellBuckling(
            **{name: data[f"buckling/{name}"] for name in BUCKLING},
            error=data.get("buckling/error"),
        )
        if "buckling/factors" in data
        else None,
        warnings=warnings_from(data),
        provenance=json_table(f"{where}: provenance", get_text(file, "provenance", "{}")),
    )


def _laminates(data: dict[str, Any], where: str) -> tuple[ShellLaminate, ...]:
    found = []
    for row, name in enumerate(data["laminates/names"]):
        own = np.flatnonzero(data["plies/laminate"] == row)
        plies = tuple(
            ShellPly(
                data["plies/material"][k],
                *(float(data[f"plies/{column}"][k]) for column in ("angle_deg", "bottom", "top")),
            )
            for k in own
        )
        found.append(
            ShellLaminate(
                name,
                plies,
                ABD=data["laminates/ABD"][row],
                Ds=data["laminates/Ds"][row],
                mass=data["laminates/mass"][row],
                stress_M=data["plies/stress_M"][own],
                report=json_table(f"{where}: laminates/reports", data["laminates/reports"][row]),
            )
        )
    return tuple(found)


def _write_view(file: h5py.File, group: h5py.Group, shell: ShellFile) -> None:
    """Add /VTKHDF: links to the mesh, virtual views of displacements, shapes and resultants."""
    view = create_grid(file, group["mesh"], "nodes_G")
    n, c = len(shell.mesh.nodes_G), len(shell.mesh.cells)
    cells = view.create_group("CellData")
    cells["region"] = group["mesh/region"]
    axes = part_view(cells, "e1", group["mesh/A_GE"], np.s_[:, :, 0], (c, 3))
    describe(axes, "-", "G")
    axes = part_view(cells, "e3", group["mesh/A_GE"], np.s_[:, :, 2], (c, 3))
    describe(axes, "-", "G")
    points = view.create_group("PointData")
    shown = [
        (name.replace("/", "-"), "displacement", "cases/displacements_G", "cases", row)
        for row, name in enumerate(shell.cases.names)
    ]
    if shell.modes is not None:
        count = len(shell.modes.frequencies)
        shown += [
            (f"mode_{row + 1:03d}", "shape", "modes/shapes_G", "modes", row) for row in range(count)
        ]
    for row, case in enumerate([] if shell.buckling is None else shell.buckling.case):
        name = f"{shell.cases.names[case].replace('/', '-')}_buckling_{row + 1:03d}"
        shape = group["buckling/shapes_G"]
        describe(part_view(points, name, shape, np.s_[row, :, :3], (n, 3)), "m", "G")
    for name, word, path, of, row in shown:
        moved = part_view(points, f"{name}_{word}", group[path], np.s_[row, :, :3], (n, 3))
        describe(moved, "m", "G")
        turned = part_view(points, f"{name}_rotation", group[path], np.s_[row, :, 3:], (n, 3))
        describe(turned, "rad", "G")
        for letter, part, unit in PARTS:
            size = part.stop - part.start
            loads = group[f"{of}/resultants_E"]
            seen = part_view(cells, f"{name}_{letter}", loads, np.s_[row, :, part], (c, size))
            describe(seen, unit, "E")
