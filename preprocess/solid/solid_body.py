"""Modal package of a solid body."""

import dataclasses
import time
from collections.abc import Mapping
from functools import partial
from typing import Any, cast

import numpy as np
import ufl

from ...solver.errors import InputError
from ...solver.math.arrays import Array
from ...solver.package import ModalPackage
from ...solver.package.body.package_schema import FaceStresses
from ...solver.package.common.cells import vtk_cells
from ...solver.package.common.materials import bond
from ...solver.package.common.plain_data import SpecError, check_form
from ...solver.package.common.plausible import body_doubts, material_doubts, not_allowed
from ...solver.package.specification import SolidSpecification
from ..exchange.import_table import SI, InterfaceTable, Reduction
from ..exchange.reduce import reduce_body
from ..fenicsx.team import ALONE, Team
from ..modes.reduced import pairs
from ..provenance import body_provenance
from .forms import strain
from .model import MOST_FACTORISED, SolidModel, from_corners
from .solid_analysis import accurate_model, coarse_mesh, findings
from .solid_mesh import CORNERS, derivatives, face_centre

# Stresses at the surface of a solid in modes and load cases, and the work of second-order strains.
#
# Surface stresses are in the axes of the materials.

BITS = 16  # of the largest value of a mode: an error below 8e-6 of it, small files


def rounded(values: Array, axes: tuple[int, ...]) -> Array:
    """Values to the last of `BITS` below the largest along axes."""
    largest = np.abs(values).max(axis=axes, keepdims=True)
    last = np.ldexp(1.0, np.frexp(largest)[1] - 1 - BITS)
    return np.asarray(np.round(values / last) * last)


def face_stress(model: SolidModel, u: Array) -> Array:
    """Stress 11 22 33 23 13 12 in material axes at the middle of all outer faces, (f, 6, m) [Pa].

    Parameters
    ----------
    u : (n, 3, m) displacements of the nodes [m]
    """
    mesh = model.mesh
    plain, A_BM = mesh.plain, face_axes(model)
    out = np.empty((len(mesh.faces), 6, u.shape[2]))
    for number in np.unique(mesh.local):
        own = np.flatnonzero(mesh.local == number)
        slope = derivatives(plain.cell, face_centre(plain.cell, int(number)))  # (3, k)
        cells = plain.cells[mesh.owner[own]]
        J = np.einsum("ak,ckx->cax", slope, plain.points[cells])
        gradient = np.linalg.solve(
            J, np.einsum("ak,ckum->caum", slope, u[cells]).reshape(len(own), 3, -1)
        ).reshape(len(own), 3, 3, -1)  # d u_b / d x_a
        e = np.stack(
            [gradient[:, k, k] for k in range(3)]
            + [gradient[:, a, b] + gradient[:, b, a] for a, b in ((1, 2), (0, 2), (0, 1))],
            axis=1,
        )
        C_M, T = model.materials.C_M[mesh.owner[own]], bond(A_BM[own])
        out[own] = C_M @ T.transpose(0, 2, 1) @ e
    return out


def face_axes(model: SolidModel) -> Array:
    """Axes A_BM (f, 3, 3) of the material at the middle of all outer faces."""
    mesh = model.mesh
    return model.materials.axes(mesh.plain.points[mesh.faces].mean(axis=1), mesh.owner)


def face_stresses(
    model: SolidModel, materials: Mapping[str, Any], u: Array, cases: Mapping[str, Array]
) -> FaceStresses:
    """Stresses of all outer faces in modes and in load cases.

    Parameters
    ----------
    model : the solid
    materials : tables of its description, by name
    u : (n, 3, m) modes
    cases : displacements (n, 3) by load case [m]
    """
    mesh, names = model.mesh, sorted(set(model.materials.names))
    of_region = np.array([names.index(name) for name in model.materials.names])
    held = face_stress(model, np.stack([*cases.values()], axis=2)) if cases else None
    return FaceStresses(
        cell=np.arange(len(mesh.faces)),
        material=of_region[mesh.plain.region[mesh.owner]],
        A_BM=face_axes(model),
        stress_M=rounded(face_stress(model, u), (0, 1)),
        materials={name: dict(materials[name]) for name in names},
        cases=tuple(cases),
        case_stress_M=None if held is None else rounded(np.moveaxis(held, 2, 0), (1, 2)),
    )


def second_order_forces(model: SolidModel, U: Array) -> Array:
    """Forces g of each pair of modes i <= j, (3 n, pairs): see exchange/inertia.py.

    Parameters
    ----------
    U : (3 n, m) displacements of the nodes in the modes
    """
    space = model.space
    v, one, other = ufl.TestFunction(space.space), space.field(), space.field()
    product = ufl.sym(ufl.grad(one).T * ufl.grad(other))
    vector = space.vectors(model.elasticity(space).work(strain(v), product))
    forces = np.empty((len(U), len(pairs(U.shape[1])[0])))
    for k, (i, j) in enumerate(zip(*pairs(U.shape[1]), strict=True)):
        space.fill(one, U[:, i].reshape(-1, 3))
        space.fill(other, U[:, j].reshape(-1, 3))
        forces[:, k] = vector()
    return forces


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
        warnings += coarse_mesh(source)
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
