"""Checks of a shell results file: shapes, numbers, rows."""

from pathlib import Path

import h5py
import numpy as np

from ..body.specification import SHELL_LINK_KINDS
from ..common.array_checks import finite, mesh_cells, one_of, rotations, rows_of, symmetric
from ..common.dataset import check_datasets, defined_sizes, misshaped, missing_or_mistyped
from ..common.remark import Remark
from .cells import QUADRILATERAL, TRIANGLE
from .layout import SHELL_GROUP, SHELL_LAYOUT, SHELL_SIZED_BY, shell_sizes, shell_values
from .schema import SHELL_MOTIONS, SHELL_RESULTANTS, ShellFile


def shell_layout_findings(group: h5py.Group) -> list[Remark]:
    """Compare the datasets of /shell with the format: presence, type, shape, cells."""
    sizes = defined_sizes(group, SHELL_SIZED_BY)
    findings = missing_or_mistyped(group, SHELL_LAYOUT) + misshaped(group, SHELL_LAYOUT, sizes)
    modes = [name for name in group.get("modes", {}) if name != "error"]
    if 0 < len(modes) < 4:
        text = f"expected frequencies, shapes_G, resultants_E and n_zero, found {', '.join(modes)}"
        findings.append(Remark("error", f"{group.name}/modes", text))
    types = group.get("mesh/cell_types")
    if not findings and not np.isin(types[()], (TRIANGLE, QUADRILATERAL)).all():
        text = f"expected triangles and quadrilaterals, types {TRIANGLE} and {QUADRILATERAL}"
        findings.append(Remark("error", f"{group.name}/mesh/cell_types", text))
    return findings


def check_shell_shapes(path: Path, shell: ShellFile) -> None:
    """Raise PackageError for the first array of a wrong type or shape."""
    values = shell_values(shell, str(path))
    check_datasets(f"{path}: /{SHELL_GROUP}", SHELL_LAYOUT, values, shell_sizes(values))


def shell_content_findings(shell: ShellFile) -> list[Remark]:
    """Check the numbers of a shell with correct shapes."""
    bad: list[Remark] = []

    def error(dataset: str, message: str) -> None:
        bad.append(Remark("error", f"/{SHELL_GROUP}/{dataset}", message))

    values = shell_values(shell)
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
