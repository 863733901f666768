"""Modal package of a beam from the 6x6 matrices of its section."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...solver.errors import coded, few
from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import MOST_MODES, rigid_motions, second_order_from_stations
from ...solver.package.body.package_schema import Interface, ModalPackage, SectionData
from ...solver.package.common.cells import node_positions
from ...solver.package.common.plain_data import SpecError
from ..modes.eigenmodes import Participation, eigenmodes
from ..modes.reduced import Modes, StaticLoad, accelerations, reduced_modes
from ..modes.reference import HELD, Condition, EigenSolver, HeldDofs, MeanAxis
from .beam_specification import BeamSpec
from .beam_stations import mass_stations, nodal_mass, places_along, point_masses
from .element import BeamElement, scaled_inverse
from .line import BeamLine, LineSection, on_x_axis
from .mode_fields import SecondOrderFields, second_order_fields, shape_resultants
from .sections import Profile, of_theory

# Input of a beam to the mode computation: reference, static and spinning shapes, mesh error.

LIMIT = 0.01  # relative frequency error above which a mesh is reported as coarse


def frequency_error(
    line: BeamLine,
    values: Array,
    columns_B: Array,
    mass_form: str,
    halves: Sequence[LineSection] | None = None,
) -> Array:
    """Estimated relative error of the frequencies, (m,); positive where they are too high.

    Parameters
    ----------
    line : the beam
    values : (m,) eigenvalues [rad2/s2]
    columns_B : (6 n, m) mass-normalised modes, body axes
    mass_form : "consistent" or "lumped"
    halves : (2 e,) sections of both halves of each element of a tapered beam; None: uniform
    """
    nodal_E = line.to_element(columns_B)
    change = np.zeros(len(values))
    for span in line.spans:
        element, mass = span.element, span.section.mass
        d = nodal_E[span.numbers]
        k, L = 2 * span.numbers[0], 0.5 * element.length
        # nodes of the halved element: first, last (12 values), middle (6)
        P = np.vstack([np.eye(12), element.shape(np.array([L]))[0]])
        first, second = np.r_[0:6, 12:18], np.r_[12:18, 6:12]
        K_fine, M_fine = np.zeros((18, 18)), np.zeros((18, 18))
        own = [span.section] * 2 if halves is None else halves[k : k + 2]
        for dofs, section in zip((first, second), own, strict=True):
            half = BeamElement(L, section.K)
            K_fine[np.ix_(dofs, dofs)] += half.stiffness()
            M_fine[np.ix_(dofs, dofs)] += half.mass_matrix(section.mass, mass_form)
        gained = P.T @ M_fine @ P - element.mass_matrix(mass, mass_form)
        change += values * np.einsum("eim,ij,ejm->m", d, gained, d, optimize=True)
        r = values * np.einsum("ij,ejm->eim", M_fine[12:] @ P, d)
        if halves is not None:  # of a uniform element both are 0
            gained = P.T @ K_fine @ P - element.stiffness()
            change -= np.einsum("eim,ij,ejm->m", d, gained, d, optimize=True)
            r -= np.einsum("ij,ejm->eim", K_fine[12:] @ P, d)
        follow = scaled_inverse(K_fine[12:, 12:])
        change += np.einsum("eim,ij,ejm->m", r, follow, r, optimize=True)
    return 0.5 * 4.0 / 3.0 * change / values


def coarse_mesh_warnings(
    labels: tuple[str, ...], error: Array, elements: int
) -> list[dict[str, str]]:
    """Warning `mesh-coarse-for-modes` naming the modes beyond LIMIT; empty if there are none.

    Parameters
    ----------
    labels : of m modes
    error : (m,) relative errors of their frequencies, of any sign
    elements : number of elements of the beam
    """
    coarse = [
        f"{label} ({abs(e):.1%})" for label, e in zip(labels, error, strict=True) if abs(e) > LIMIT
    ]
    if not coarse:
        return []
    message = (
        f"{elements} elements are too few for the modes {few(coarse)}: estimated frequency "
        f"error above {LIMIT:.0%}; increase `elements`"
    )
    return coded("mesh-coarse-for-modes", message)


# Transverse displacement, and the rotation that equals its slope, with its sign.
PLANES = {"spinning-xy": (1, 5, 1.0), "spinning-xz": (2, 4, -1.0)}


def spinning_loads(
    condition: Condition, line: BeamLine, requested: tuple[tuple[str, int], ...], origin: int
) -> list[StaticLoad]:
    """Loads of the static modes "spinning-xy" and "spinning-xz".

    Parameters
    ----------
    condition : reference condition; not a mean axis, because a mean axis carries the first load
    line : the beam, straight and, for the tension, uniform
    requested : key of PLANES and number of shapes
    origin : node on the axis of rotation
    """
    x = line.nodes_B[:, 0] - line.nodes_B[origin, 0]
    tension = 0.5 * (np.where(x < 0.0, x[0], x[-1]) ** 2 - x**2)
    zero = np.zeros(6 * line.n_node)
    loads = []
    for kind, count in requested:
        across, turning, sign = PLANES[kind]
        pull = x
        for k in range(count):
            acceleration = np.zeros((line.n_node, 6))
            acceleration[:, across] = pull / np.abs(pull).max()
            load = acceleration.ravel()
            loads.append(StaticLoad(f"{kind} {k + 1}", zero, load))
            shape = condition.static(zero[:, None], load[:, None]).columns[:, 0]
            slope = sign * shape.reshape(-1, 6)[:, turning]
            order: Literal[1, 2] = 2 if line.n_node > 2 else 1
            pull = np.gradient(tension * slope, line.nodes_B[:, 0], edge_order=order)
    return loads


def reference_condition(
    line: BeamLine, mass_form: str, kind: str, nodes: tuple[int, ...]
) -> Condition:
    """Reference condition of a beam.

    Parameters
    ----------
    line : the beam
    mass_form : "consistent" or "lumped": of the eigenproblem and of the mean axis
    kind : one of REFERENCE_CONDITIONS
    nodes : nodes that carry the frame: one if clamped, two for a chord; for a mean axis none, or
        two that carry the loads of static shapes as a chord does

    Raises
    ------
    ModeError : a mean axis of a body without inertia about some axis.
    """
    K, M = line.stiffness(), line.mass_matrix(mass_form)
    held = held_dofs(kind, nodes)
    if held is None:
        rigid = rigid_motions(line.nodes_B).reshape(6 * line.n_node, 6)
        still = held_dofs("chord", nodes) if nodes else None
        return MeanAxis(K, M, rigid, still=still, reactions=bool(nodes))
    return HeldDofs(K, M, held)


def held_dofs(kind: str, nodes: tuple[int, ...]) -> IntArray | None:
    """Dofs (6,) that are fixed in the frame of `reference_condition`; None for a mean axis."""
    if kind == "mean-axis":
        return None
    return np.array([6 * n + dof for n, own in zip(nodes, HELD[kind], strict=True) for dof in own])


def unit_forces(line: BeamLine, node_of: dict[str, int]) -> Array:
    """Unit forces and moments at the interfaces with these nodes, (6 n, 6 i)."""
    at = [6 * node + k for node in node_of.values() for k in range(6)]
    forces = np.zeros((6 * line.n_node, len(at)))
    forces[at, np.arange(len(at))] = 1.0
    return forces


def unit_loads(condition: Condition, line: BeamLine, forces: Array) -> Array:
    """Unit loads (6 n, 6 i + 12) of the compliance of a package: of i interfaces, and inertia.

    The nodes turn with the slope t x A t of the moved line, and with half of the curl about its
    tangent t: a consistent mass would bend elements whose ends do not turn.

    Parameters
    ----------
    condition : reference condition, which has the mass
    line : the beam, n nodes
    forces : (6 n, 6 i) unit forces and moments at the interfaces
    """
    fields = accelerations(np.repeat(line.nodes_B, 6, axis=0), np.arange(len(forces)) % 6)
    t = np.gradient(line.nodes_B, line.along, axis=0)
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    slope = np.einsum("nak,nb->nkab", np.cross(t[:, None], np.eye(3)), t)
    turns = fields.reshape(-1, 6, 3, 4)[:, 3:, :, :3]
    turns[:] = slope + np.einsum("nk,nl,nlab->nkab", t, t, turns)
    return np.hstack([forces, condition.M @ fields])


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
