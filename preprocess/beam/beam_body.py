"""Modal package of a beam from the 6x6 matrices of its section."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import MOST_MODES, second_order_from_stations
from ...solver.package.body.package_schema import Interface, ModalPackage, SectionData
from ...solver.package.common.cells import node_positions
from ...solver.package.common.plain_data import SpecError
from ..modes.eigenmodes import Participation, eigenmodes
from ..modes.reduced import Modes, StaticLoad, reduced_modes
from ..modes.reference import Condition, EigenSolver
from .beam_reduction import (
    coarse_mesh_warnings,
    frequency_error,
    held_dofs,
    reference_condition,
    spinning_loads,
    unit_forces,
    unit_loads,
)
from .beam_specification import BeamSpec
from .beam_stations import mass_stations, nodal_mass, places_along, point_masses
from .line import BeamLine, LineSection, on_x_axis
from .mode_fields import SecondOrderFields, second_order_fields, shape_resultants
from .sections import Profile, of_theory

VTK_LINE = 3


@dataclass(frozen=True)
class BeamModel:
    """A beam mesh with the interfaces of its specification."""

    spec: BeamSpec
    line: BeamLine
    profile: Profile
    node_of: dict[str, int]  # interface name -> row of nodes_B
    reference_nodes: tuple[int, ...]  # nodes that carry the frame

    @property
    def carried(self) -> bool:
        """Whether nodes carry the loads of static shapes in a mean axis."""
        return self.spec.reference.kind == "mean-axis" and bool(self.reference_nodes)

    @property
    def loaded_nodes(self) -> tuple[int, ...]:
        """Nodes where reactions of the frame or loads of attachment modes act."""
        attached = (self.node_of[at] for at, _ in self.spec.modes.attachments)
        return tuple(sorted({*self.reference_nodes, *attached}))


def beam_model(spec: BeamSpec, *sections: LineSection) -> BeamModel:
    """Mesh a beam; every interface gets a node.

    Parameters
    ----------
    spec : the checked specification
    sections : those of its stations; one for a uniform beam

    Raises
    ------
    SpecError : fewer elements than interfaces need.
    """
    places = {**spec.interfaces, **dict(spec.reference.places)}
    nodes_B, A_BE = spec.nodes_B, spec.A_BE
    if nodes_B is None:
        try:
            x_B = node_positions(spec.length, spec.elements, list(places.values()))
        except ValueError as error:
            raise SpecError(f"elements: {error}, found {spec.elements}") from error
        nodes_B, A_BE = on_x_axis(x_B), np.tile(A_BE, (len(x_B) - 1, 1, 1))
    profile = Profile(spec.stations, tuple(of_theory(s, spec.theory) for s in sections))
    line = profile.line(nodes_B, A_BE)
    node_of = {
        name: int(np.argmin(np.abs(line.along - place * line.along[-1])))
        for name, place in places.items()
    }
    nodes = tuple(node_of[name] for name, _ in spec.reference.places)
    return BeamModel(spec, line, profile, {name: node_of[name] for name in spec.interfaces}, nodes)


def beam_modes(model: BeamModel, solver: EigenSolver) -> Modes:
    """Modes of the beam in its reference condition, with the mass form of its specification.

    Raises ModeError for modes or a mean axis that the beam does not have.
    """
    condition, loads, unit = beam_input(model, solver)
    requests = () if model.carried else model.spec.modes.eigenmodes
    return reduced_modes(condition, requests, loads, *_kinds(model), solver, unit_loads=unit)


def _kinds(model: BeamModel) -> tuple[Participation, IntArray]:
    """What sorts eigenmodes: their share in each kind of motion, and the nodes from far to near."""
    line, form = model.line, model.spec.mass_form
    first = model.reference_nodes[0] if model.reference_nodes else 0
    far_to_near = np.argsort(-np.abs(line.along - line.along[first]), kind="stable")
    return lambda columns_B: mass_stations(line, columns_B, form).participation(), far_to_near


def beam_input(model: BeamModel, solver: EigenSolver) -> tuple[Condition, list[StaticLoad], Array]:
    """Reference condition, loads of static modes, and unit loads of the compliance.

    Vibrations of a body in a mean axis whose loads a chord carries are those of the chord: static
    shapes of their inertia.
    """
    line, spec, nodes = model.line, model.spec, model.reference_nodes
    first = nodes[0] if nodes else 0
    condition = reference_condition(line, spec.mass_form, spec.reference.kind, nodes)
    forces = unit_forces(line, model.node_of)
    # for a mean axis the load along the beam is zero at the mass centre in any case
    outwards = line.nodes_B[:, 0] - line.nodes_B[first, 0]
    loads = spec.modes.static_loads(forces, list(model.node_of), outwards, line.nodes_B)
    loads += spinning_loads(condition, line, spec.modes.spinning, first)
    if model.carried and spec.modes.eigenmodes:
        chord = reference_condition(line, spec.mass_form, "chord", nodes)
        modes = eigenmodes(chord, spec.modes.eigenmodes, *_kinds(model), solver)
        for label, value, column in zip(modes.labels, modes.values, modes.columns_B.T, strict=True):
            loads.append(StaticLoad(label, np.zeros_like(column), value * column))
    return condition, loads, unit_loads(condition, line, forces)


def beam_package(
    model: BeamModel,
    modes: Modes,
    sections: Sequence[SectionData],
    provenance: dict[str, object],
    *,
    second_order: bool = True,
) -> ModalPackage:
    """Collect mesh, modes and inertia of a beam in a modal package.

    A tapered beam has stresses at the nodes of its stations, and K and M of the sections at all
    nodes. The nodal masses are always lumped. The invariants use the mass form of the
    specification, which is also that of the eigenproblem.

    Parameters
    ----------
    model, modes : of the beam
    sections : of the stations, with their stresses
    provenance : of the package
    second_order : with terms of second order
    """
    spec, line = model.spec, model.line
    n, m = line.n_node, len(modes.values)
    shapes_B = np.ascontiguousarray(np.moveaxis(modes.columns_B.reshape(n, 6, m), 2, 0))
    points = point_masses(mass_stations(line, modes.columns_B, spec.mass_form))
    fields = None
    if 0 < m <= MOST_MODES and second_order:
        held = held_dofs(spec.reference.kind, model.reference_nodes)
        fields = second_order_fields(line, modes.columns_B, points, spec.mass_form, held)
    node_mass, node_inertia_B = nodal_mass(line)
    at_nodes = model.profile.at_nodes(line, sections)
    recovery = shape_resultants(
        line, modes.columns_B, modes.accelerations_B, spec.mass_form, model.loaded_nodes
    )
    if len(at_nodes) > 1:
        recovery = replace(recovery, section=np.searchsorted(line.along, recovery.station_x))
    if not line.is_straight:  # places of users are along the line, not along its elements
        stretch = spec.length / line.along[-1]
        recovery = replace(recovery, station_x=recovery.station_x * stretch)
    first = np.arange(n - 1, dtype=np.int64)
    node_ids = np.arange(1, n + 1, dtype=np.int64)
    return ModalPackage(
        **modes.of_package(spec.damping_ratio),
        body=spec.body,
        nodes_B=line.nodes_B,
        node_ids=node_ids,
        connectivity=np.column_stack([first, first + 1]).ravel(),
        offsets=np.arange(0, 2 * n - 1, 2, dtype=np.int64),
        cell_types=np.full(n - 1, VTK_LINE, dtype=np.int64),
        shapes_B=shapes_B,
        node_mass=node_mass,
        node_inertia_B=node_inertia_B,
        invariants=points.invariants(spec.mass_form),
        interfaces=tuple(
            _interface(name, row, line.nodes_B, node_ids, shapes_B, fields)
            for name, row in model.node_of.items()
        ),
        reference_condition=spec.reference.kind,
        sections=at_nodes,
        recovery=recovery,
        mode_labels=modes.labels,
        provenance=provenance,
        second_order=None
        if fields is None
        else second_order_from_stations(
            points.m,
            points.x_B,
            points.phi_B,
            fields.h_B,
            places_along(line, spec.mass_form)[points.slice_of],
        ),
    )


def mode_warnings(model: BeamModel, modes: Modes) -> list[dict[str, str]]:
    """Warnings about omitted modes, and about a mesh that is too coarse for the kept modes."""
    n_eigen = modes.kinds.count("fixed_normal")
    error = mesh_error(model, modes)[:n_eigen]
    coarse = coarse_mesh_warnings(modes.labels[:n_eigen], error, model.spec.elements)
    return [*modes.warnings, *coarse]


def mesh_error(model: BeamModel, modes: Modes) -> Array:
    """Relative error of the frequency of each mode by the mesh, (m,)."""
    line, halves = model.line, None
    if len(model.profile.sections) > 1:
        middles = 0.5 * (line.nodes_B[:-1] + line.nodes_B[1:])
        nodes = np.insert(line.nodes_B, np.arange(1, line.n_node), middles, axis=0)
        halves = model.profile.line(nodes, np.repeat(line.A_BE, 2, axis=0)).sections
    form = model.spec.mass_form
    return frequency_error(line, modes.values, modes.columns_B, form, halves)


def stiffness_error(model: BeamModel, modes: Modes, stiffer: Sequence[LineSection]) -> Array:
    """Expected error of the modal stiffness, (m, m) [N m].

    The errors add up, whatever their signs.

    Parameters
    ----------
    model : of the beam
    modes : of the beam
    stiffer : sections of its stations, with their errors of K added to K twice
    """
    line = beam_model(model.spec, *stiffer).line
    gained = modes.columns_B.T @ (line.stiffness() - model.line.stiffness()) @ modes.columns_B
    mesh = np.diag(2.0 * np.abs(mesh_error(model, modes)) * modes.values)
    return np.asarray(0.5 * (gained + gained.T) + mesh)


def _interface(
    name: str,
    row: int,
    nodes_B: Array,
    node_ids: IntArray,
    shapes_B: Array,
    fields: SecondOrderFields | None,
) -> Interface:
    return Interface(
        name=name,
        kind="node",
        node_ids=node_ids[[row]],
        weights=np.ones(1),
        position_B=nodes_B[row],
        A_BI=np.eye(3),
        phi_B=shapes_B[:, row, :3].T,
        psi_B=shapes_B[:, row, 3:].T,
        H_B=None if fields is None else fields.node_u_B[row],
        H_psi_B=None if fields is None else fields.node_f_B[row],
    )
