"""Modal package of a body from a laminated shell, with the data of its stress recovery."""

import time
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.body.invariants import MOST_MODES, second_order_from_stations
from ....solver.package.body.package_schema import (
    CellResultants,
    LaminateData,
    ModalPackage,
    SecondOrder,
)
from ....solver.package.body.selection import ALONG
from ....solver.package.common.cells import vtk_cells
from ....solver.package.common.design import difference
from ....solver.package.section.stress import rounded
from ...beam.beam_stations import Stations
from ...design import body_parameters, change_of_inputs, derivatives
from ...modes.rates import Change
from ...modes.reduced import Modes, StaticLoad, reduced_modes
from ...modes.reference import Condition
from ...parameters import Parameter
from ...provenance import body_provenance
from ..model.regions import cell_axes
from ..model.shell_problem import ShellProblem
from ..model.states import interface_warnings, warped_warnings
from .interfaces import (
    ShellBodySpec,
    interfaces,
    mass_stations,
    node_shapes,
    places,
    read_shell_body,
)
from .second_order import Near, second_order_columns, second_order_fields
from .shell_reduction import ShellModel, eigen_solver
from .stiffness_rates import not_linear, stiffness_rates


def cell_resultants(problem: ShellProblem, u: Array, exact: bool = False) -> CellResultants:
    """Mean resultants of every cell per unit mode, in the order of the mesh file.

    Parameters
    ----------
    u : (n_dof, m) motion of all degrees of freedom
    exact : False to round them like the recovery of sections, which halves the size of the
        compressed data
    """
    mesh, names = problem.mesh, list(problem.laminates)
    laminate = np.empty(len(mesh.cells), dtype=np.int64)
    for region in problem.regions:
        laminate[region.cells] = names.index(region.laminate_name)
    resultants = np.ascontiguousarray(np.moveaxis(problem.resultants(u), 0, 2))
    return CellResultants(
        cell=np.arange(len(mesh.cells)),
        laminate=laminate,
        A_BE=cell_axes(mesh, problem.regions),
        resultants_E=resultants if exact else rounded(resultants),
    )


def laminates(problem: ShellProblem) -> tuple[LaminateData, ...]:
    """Every laminate that a region uses, once."""
    constants = problem.spec["materials"]
    return tuple(
        region.laminate.data(name, region.stiffness, constants)
        for name, region in problem.laminates.items()
    )


DESIGNED = {"laminates", "materials", "regions", "stiffeners"}  # tables with design parameters
SPARE = 1  # additional modes: a shell has other modes between those of one kind


def build_shell_body(spec: Mapping[str, object]) -> ModalPackage:
    """Assemble the shell, solve its modes and collect the package of one body.

    Parameters
    ----------
    spec : plain JSON, see solver/package/specification.py

    Raises
    ------
    SpecError : an unknown or missing key, or a value of another type
    ModeError : fewer modes of a kind than requested
    ShellError, LaminateError, MaterialError : errors in the description of the shell
    """
    body, parameters = read_shell_body(spec), body_parameters(spec)
    start = time.perf_counter()
    model = shell_model(body)
    model.condition  # noqa: B018  matrices
    assembled = time.perf_counter()
    modes = shell_modes(model)
    u = model.problem.freedom.expanded(modes.columns_B)
    mode_warnings = warped_warnings(model.problem, u, [f"mode {_label(m)}" for m in modes.labels])
    mode_warnings += interface_warnings(model.problem, u, modes.values, body.modes.attachments)
    solved = time.perf_counter()
    provenance = body_provenance(
        spec,
        {"body": model.problem.freedom.n_dof},
        {"shell": assembled - start, "modes": solved - assembled},
        [
            *model.problem.warnings,
            *(() if spec.get("candidates") else (*mode_warnings, *modes.warnings)),
        ],
    )
    package = shell_package(model, modes, provenance, exact=bool(parameters))
    if not parameters:
        return package
    if why := not_linear(model.problem):
        package.provenance["no_stiffness_rates"] = why
    else:
        rates = stiffness_rates(model.problem, u)
        data = (replace(each, stiffness_rates=rates[each.name]) for each in package.laminates)
        package = replace(package, laminates=tuple(data))
    near = None
    if package.second_order is not None:
        columns = second_order_columns(model.problem, model.condition, u)
        near = Near(model.condition, columns)

    def at(p: Parameter, distance: float) -> ShellModel:
        """The shell with a parameter moved."""
        moved = p.moved(distance)
        shell = body.shell | {key: moved["shell"][key] for key in DESIGNED & moved["shell"].keys()}
        ratio = float(moved["damping_ratio"])
        problem = model.problem.relaid(shell)
        return ShellModel(replace(body, shell=shell, damping_ratio=ratio), problem)

    design = derivatives(
        parameters,
        model.condition,
        modes,
        at,
        shell_change(model),
        lambda moved, modes: shell_package(moved, modes, {}, True, near),
        body.damping_ratio,
    )
    return replace(package, design=design)


def shell_model(body: ShellBodySpec) -> ShellModel:
    """Mesh, lay-ups and interfaces of a body."""
    model = ShellModel(body, ShellProblem(body.shell, "shell"))
    model.check()
    return model


def shell_input(model: ShellModel) -> tuple[Condition, list[StaticLoad], Array]:
    """Reference condition, loads of static modes, and unit loads of the compliance."""
    return model.condition, model.static_loads(), model.unit_loads()


def shell_change(model: ShellModel) -> Callable[[Parameter, list[ShellModel]], Change]:
    """Derivatives of the FE model by a parameter, from those at the places of its differences."""
    freedom, n_load = model.problem.freedom, len(model.static_loads())
    fields, unit = model.unit_accelerations(), model.unit_loads()

    def change(p: Parameter, at: list[ShellModel]) -> Change:
        if any(one.problem.freedom is not freedom for one in at):  # links follow the laminates
            return change_of_inputs(p, [shell_input(one) for one in at])
        K = freedom.reduced(difference([one.problem.K for one in at], p.step))
        M = 0.0 * model.condition.M
        if any(one.problem.M is not model.problem.M for one in at):
            M = freedom.reduced(difference([one.problem.M for one in at], p.step))
        n = unit.shape[1] - fields.shape[1] + n_load
        forces = np.hstack([np.zeros((len(unit), n)), M @ fields])
        return Change(p.name, K, M, forces, np.zeros_like(forces))

    return change


def shell_modes(model: ShellModel) -> Modes:
    """Modes of the shell in its reference condition, in its independent degrees of freedom.

    Raises ModeError for modes or a mean axis that the shell does not have.
    """
    modes = model.spec.modes
    lowest = all(request.kind == "lowest" for request in modes.eigenmodes)
    condition, loads, unit = shell_input(model)
    return reduced_modes(
        condition,
        modes.eigenmodes,
        loads,
        model.participation,
        model.far_to_near(),
        eigen_solver,
        SPARE if lowest else 4 * SPARE,
        unit,
    )


def shell_package(
    model: ShellModel,
    modes: Modes,
    provenance: dict[str, object],
    exact: bool = False,
    near: Near | None = None,
) -> ModalPackage:
    """Collect mesh, modes, inertia and laminates of a shell in a modal package.

    The nodal masses are always lumped. The invariants use the mass form
    of the specification, which is also that of the eigenproblem.

    Parameters
    ----------
    model : the shell
    modes : of its condition
    provenance : where the package comes from
    exact : resultants of cells are not rounded, as derivatives of packages need
    near : for `second_order_fields`
    """
    problem, spec = model.problem, model.spec
    mesh, links = problem.mesh, problem.links
    u = problem.freedom.expanded(modes.columns_B)
    m = u.shape[1]
    at = places(mesh, links, model.carriers if spec.reference.kind == "chord" else ())
    connectivity, offsets, types = vtk_cells(mesh.cells)
    nodes = u.reshape(len(u) // 6, 6, m)[: mesh.n_node]  # not -1: a rigid body has no modes
    stations = mass_stations(mesh, problem.regions, problem.stiffeners, nodes, problem.mass_form)
    h = None
    if spec.second_order and 0 < m <= MOST_MODES:
        h = second_order_fields(problem, model.condition, u, near)
    node_mass, node_inertia = np.zeros(len(at.ids)), np.zeros((len(at.ids), 3, 3))
    for whole, of_mesh in zip((node_mass, node_inertia), model.nodal_mass, strict=True):
        whole[: mesh.n_node] = of_mesh
    return ModalPackage(
        **modes.of_package(spec.damping_ratio),
        body=spec.body,
        nodes_B=at.nodes_B,
        node_ids=at.ids,
        connectivity=connectivity,
        offsets=offsets,
        cell_types=types,
        shapes_B=node_shapes(mesh, links, at, u),
        node_mass=node_mass,
        node_inertia_B=node_inertia,
        invariants=stations.invariants(problem.mass_form),
        interfaces=interfaces(spec.interfaces, mesh, links, at, u, h),
        reference_condition=spec.reference.kind,
        laminates=laminates(problem),
        cell_resultants=cell_resultants(problem, u, exact),
        mode_labels=tuple(map(_label, modes.labels)),
        provenance=provenance,
        second_order=None if h is None else _second_order(model, stations, h),
    )


def _second_order(model: ShellModel, stations: Stations, h: Array) -> SecondOrder:
    """Sums over the stations of their second-order motion.

    A station at an arm from the mesh, with offset plies, moves with the rotation of its node too.
    """
    problem, pairs = model.problem, h.reshape(len(h) // 6, 6, -1)[: model.problem.mesh.n_node]
    moved = mass_stations(
        problem.mesh, problem.regions, problem.stiffeners, pairs, problem.mass_form
    )
    h_B = moved.phi_B.reshape(*moved.phi_B.shape[:2], *h.shape[1:])
    return second_order_from_stations(stations.m, stations.x_B, stations.phi_B, h_B)


def _label(label: str) -> str:
    """Label of a shell mode by its main direction: "bending-xz 2" becomes "along z 2"."""
    kind, _, number = label.rpartition(" ")
    return f"{ALONG[kind]} {number}" if kind in ALONG else label
