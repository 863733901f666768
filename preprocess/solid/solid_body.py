"""Modal package of a solid body."""

import dataclasses
import time
from collections.abc import Mapping
from functools import partial
from typing import Any, cast

import numpy as np

from ...solver.errors import InputError
from ...solver.math.arrays import Array
from ...solver.package import ModalPackage
from ...solver.package.common.cells import vtk_cells
from ...solver.package.common.plain_data import SpecError, check_form
from ...solver.package.common.plausible import body_doubts, material_doubts, not_allowed
from ...solver.package.specification import SolidSpecification
from ..exchange.import_table import SI, InterfaceTable, Reduction
from ..exchange.reduce import reduce_body
from ..fenicsx.team import ALONE, Team
from ..provenance import body_provenance
from .model import MOST_FACTORISED, SolidModel, from_corners
from .solid_analysis import accurate_model, findings
from .solid_mesh import CORNERS
from .surface_stresses import face_stresses, rounded, second_order_forces

NOT_COUNTED = {
    "code": "modes-not-counted",
    "message": f"a solid of more than {MOST_FACTORISED} unknowns is not factorised, so that its "
    "vibrations are not counted: one may be missing; compare with a coarser mesh",
}


def build_solid_body(spec: Mapping[str, object], team: Team = ALONE) -> ModalPackage:
    """Mesh the solid, solve its modes and collect the package of one body.

    Parameters
    ----------
    spec : plain JSON, see solver/package/specification.py
    team : processes that all call this and share the matrices; each gets the package

    Raises
    ------
    SpecError : an unknown or missing key, a value of another type, a request that the solid
        cannot fulfil.
    SolidError : what is wrong with geometry, mesh, materials or interfaces
    """
    table = check_form(spec, SolidSpecification)
    start, where = time.perf_counter(), "" if "analysis" in table else f"bodies.{table['body']}"
    model = accurate_model(table["solid"], table["interfaces"], where, team)
    model.body  # noqa: B018  matrices
    assembled = time.perf_counter()
    reduction: Reduction = {
        "body": table["body"],
        "reference": table["reference"],
        "modes": cast(Any, table["modes"]),
        "interfaces": _followed(model.links) if "analysis" in table else model.links,
        "units": SI,
        "damping_ratio": table["damping_ratio"],
    }
    try:
        bending = partial(second_order_forces, model) if table.get("second_order") else None
        package = reduce_body(model.body, reduction, solver=model.solver, second_order=bending)
    except InputError as error:
        raise SpecError(str(error).removeprefix(": ")) from error
    n = len(model.body.nodes)
    cases: dict[str, Array] = {}
    source = package.provenance["source"]
    warnings = [*package.provenance["warnings"], *([] if model.counts else [NOT_COUNTED])]
    if "analysis" in table:  # the checks of a run judge the bodies of a mechanism
        source, cases = findings(model, package, table["analysis"])
        doubts = [
            *material_doubts(table["solid"]["materials"]),
            *body_doubts(package.invariants.mass),
        ]
        warnings += [doubt.warning for doubt in not_allowed(table["solid"], doubts)]
    shapes = np.moveaxis(package.shapes_B[:, :n, :3], 0, 2)
    stresses = face_stresses(model, table["solid"]["materials"], shapes, cases)
    seconds = {"solid": assembled - start, "modes": time.perf_counter() - assembled}
    provenance = body_provenance(spec, {"body": 3 * n}, seconds, warnings)
    return dataclasses.replace(
        _at_corners(package, model),
        face_stresses=stresses,
        provenance={**provenance, "ranks": model.team.size, "solid": source},
    )


def _at_corners(package: ModalPackage, model: SolidModel) -> ModalPackage:
    """The package with its outer faces as cells and without the nodes between the corners of cells.

    Corners take the mass of these nodes, in the proportions of linear functions, so that mass and
    centre stay. Shapes are rounded, except those of the reference points.
    """
    mesh, n = model.mesh, len(model.body.nodes)
    kept = np.unique(mesh.plain.cells[:, : CORNERS[mesh.plain.cell]])
    rows = np.concatenate([kept, np.arange(n, len(package.nodes_B))])
    mass, shapes = package.node_mass.copy(), package.shapes_B[:, rows]
    mass[:n] = from_corners(mesh.plain).T @ mass[:n]
    if len(shapes):
        shapes[:, : len(kept)] = rounded(shapes[:, : len(kept)], (1, 2))
    connectivity, offsets, types = vtk_cells(np.searchsorted(kept, mesh.corners))
    return dataclasses.replace(
        package,
        nodes_B=package.nodes_B[rows],
        node_ids=package.node_ids[rows],
        connectivity=connectivity,
        offsets=offsets,
        cell_types=types,
        shapes_B=shapes,
        node_mass=mass[rows],
        node_inertia_B=package.node_inertia_B[rows],
    )


def _followed(links: dict[str, InterfaceTable]) -> dict[str, InterfaceTable]:
    """Interfaces that do not stiffen the free solid."""
    return {name: {**table, "link": "average"} for name, table in links.items()}
