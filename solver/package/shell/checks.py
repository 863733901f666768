"""Checks of a shell results file: numbers and rows."""

import numpy as np

from ..common.array_checks import finite, mesh_cells, one_of, rotations, rows_of, symmetric
from ..common.dataset import field_values
from ..common.remark import Remark
from ..specification import SHELL_LINK_KINDS
from .schema import SHELL_MOTIONS, SHELL_RESULTANTS, ShellFile


def shell_content_findings(shell: ShellFile) -> list[Remark]:
    """Check the numbers of a shell with correct shapes."""
    bad: list[Remark] = []

    def error(dataset: str, message: str) -> None:
        bad.append(Remark("error", f"/shell/{dataset}", message))

    found = field_values(shell)
    for path, value in found.items():
        finite(path, value, error)
    if bad:
        return bad  # the other checks would report the same error
    mesh = shell.mesh
    mesh_cells(found["mesh/offsets"], found["mesh/connectivity"], len(mesh.nodes_G), error)
    rows_of("mesh/region", mesh.region, len(mesh.regions), error)
    rows_of("mesh/laminate", mesh.laminate, len(shell.laminates), error)
    rotations("mesh/A_GE", mesh.A_GE, error)
    for path, names in (
        ("mesh/regions", mesh.regions),
        ("mesh/node_ids", mesh.node_ids.tolist()),
        ("laminates/names", found["laminates/names"]),
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
