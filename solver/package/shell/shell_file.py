"""Write, read and check a shell results file: HDF5, and a valid VTKHDF file."""

from pathlib import Path

import h5py
import numpy as np

from ..common.dataset import field_values
from ..common.findings import Remark, finite, mesh_cells, one_of, rotations, rows_of, symmetric
from ..common.object_file import ObjectFormat, read_object, write_object
from ..common.vtk_view import create_grid, describe, part_view
from ..specification import SHELL_LINK_KINDS
from .shell_schema import (
    SHELL_FORMAT,
    SHELL_FORMAT_VERSION,
    SHELL_MOTIONS,
    SHELL_RESULTANTS,
    ShellFile,
)


def shell_content_findings(shell: ShellFile) -> list[Remark]:
    """Check the numbers of a shell with correct shapes."""
    bad: list[Remark] = []

    def error(dataset: str, message: str) -> None:
        bad.append(Remark("error", f"/shell/{dataset}", message))

    values = field_values(shell)
    for path, value in values.items():
        finite(path, value, error)
    if bad:
        return bad  # the other checks would report the same error
    mesh = shell.mesh
    mesh_cells(values["mesh/offsets"], values["mesh/connectivity"], len(mesh.nodes_G), error)
    rows_of("mesh/region", mesh.region, len(mesh.regions), error)
    rows_of("mesh/laminate", mesh.laminate, len(shell.laminates), error)
    rotations("mesh/A_GE", mesh.A_GE, error)
    for path, names in (
        ("mesh/regions", mesh.regions),
        ("mesh/node_ids", mesh.node_ids.tolist()),
        ("laminates/names", values["laminates/names"]),
        ("cases/names", shell.cases.names),
    ):
        if len(set(names)) != len(names):
            error(path, "expected unique values, some occur twice")
    for laminate in shell.laminates:
        symmetric("laminates/ABD", laminate.ABD, error)
        symmetric("laminates/Ds", laminate.Ds, error)
        if not laminate.plies:
            error("plies/laminate", f"laminate {laminate.name!r} has no plies")
    known = (*SHELL_MOTIONS, *SHELL_RESULTANTS)
    one_of("probes/quantities", shell.probes.quantities, known, error)
    if shell.buckling is not None:
        rows_of("buckling/case", shell.buckling.case, len(shell.cases.names), error)
        if np.any(shell.buckling.factors <= 0.0):
            error("buckling/factors", "expected numbers above 0")
    one_of("links/kinds", shell.links.kinds, SHELL_LINK_KINDS, error)
    return bad


PARTS = (("N", slice(0, 3), "N/m"), ("M", slice(3, 6), "N"), ("T", slice(6, 8), "N/m"))


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


SHELL_FILE = ObjectFormat(
    SHELL_FORMAT,
    SHELL_FORMAT_VERSION,
    "shell",
    "name",
    ShellFile,
    "a shell file",
    "nodes_G",
    shell_content_findings,
    _write_view,
)


def write_shell(path: str | Path, shell: ShellFile) -> None:
    """Write a shell results file; see `write_object`."""
    write_object(path, SHELL_FILE, shell)


def read_shell(path: str | Path) -> ShellFile:
    """Read a shell results file and check that its numbers can be used; see `read_object`."""
    return read_object(path, SHELL_FILE)
