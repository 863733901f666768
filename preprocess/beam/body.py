"""From a section's 6x6 matrices to the modal package of a beam."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...solver.package.schema import Array, IntArray, Interface, ModalPackage, SectionData
from ..modes import EigenSolver, Modes, constrained_modes
from .accuracy import coarse_mesh_warnings, frequency_error
from .line import BeamLine, node_positions
from .resultants import mode_resultants
from .spec import BeamSpec, SpecError
from .stations import mass_stations, nodal_mass
from .theory import section_stiffness

VTK_LINE = 3


@dataclass(frozen=True)
class BeamModel:
    """A beam mesh with the places that its specification names."""

    spec: BeamSpec
    line: BeamLine
    node_of: dict[str, int]  # interface name -> row of nodes_B
    reference_node: int


def beam_model(spec: BeamSpec, K: Array, mass: Array) -> BeamModel:
    """Mesh a beam; every interface gets a node.

    Parameters
    ----------
    spec : the checked specification
    K, mass : (6, 6) section stiffness and mass per length, section axes

    Raises
    ------
    SpecError : fewer elements than interfaces need.
    """
    reference, fraction = spec.reference
    places = {**spec.interfaces, reference: fraction}
    try:
        x_B = node_positions(spec.length, spec.elements, list(places.values()))
    except ValueError as error:
        raise SpecError(f"elements: {error}, found {spec.elements}") from error
    line = BeamLine(x_B, section_stiffness(K, spec.theory), mass, spec.A_BE)
    node_of = {
        name: int(np.argmin(np.abs(x_B - place * spec.length))) for name, place in places.items()
    }
    reference_node = node_of[reference]
    return BeamModel(spec, line, {name: node_of[name] for name in spec.interfaces}, reference_node)


def beam_modes(model: BeamModel, solver: EigenSolver) -> Modes:
    """Modes of the beam clamped at its reference node, with the mass form of its specification."""
    line, reference = model.line, model.reference_node
    mass_form = model.spec.mass_form
    distance = np.abs(line.x_B - line.x_B[reference])
    return constrained_modes(
        line.stiffness(),
        line.mass_matrix(mass_form),
        6 * reference + np.arange(6),
        model.spec.modes,
        lambda columns_B: mass_stations(line, columns_B, mass_form).participation(),
        np.argsort(-distance, kind="stable"),
        solver,
    )


def beam_package(
    model: BeamModel, modes: Modes, section: SectionData, provenance: dict[str, Any]
) -> ModalPackage:
    """Put mesh, modes and inertia of a beam into the package of the solver.

    The nodal masses describe the nodes and are always lumped; the invariants
    carry the mass form of the specification, that of the eigenproblem.
    """
    spec, line = model.spec, model.line
    n, m = line.n_node, len(modes.values)
    shapes_B = np.ascontiguousarray(np.moveaxis(modes.columns_B.reshape(n, 6, m), 2, 0))
    stations = mass_stations(line, modes.columns_B, spec.mass_form)
    node_mass, node_inertia_B = nodal_mass(line)
    frequencies = np.sqrt(modes.values)
    first = np.arange(n - 1, dtype=np.int64)
    node_ids = np.arange(1, n + 1, dtype=np.int64)
    return ModalPackage(
        body=spec.body,
        nodes_B=line.nodes_B,
        node_ids=node_ids,
        connectivity=np.column_stack([first, first + 1]).ravel(),
        offsets=np.arange(0, 2 * n - 1, 2, dtype=np.int64),
        cell_types=np.full(n - 1, VTK_LINE, dtype=np.int64),
        shapes_B=shapes_B,
        mode_kinds=("fixed_normal",) * m,
        frequencies=frequencies,
        mass=np.eye(m),
        stiffness=np.diag(modes.values),
        damping=np.diag(2.0 * spec.damping_ratio * frequencies),
        node_mass=node_mass,
        node_inertia_B=node_inertia_B,
        invariants=stations.invariants(spec.mass_form),
        interfaces=tuple(
            _interface(name, row, line.nodes_B, node_ids, shapes_B)
            for name, row in model.node_of.items()
        ),
        reference_condition="clamped",
        sections=(section,),
        recovery=mode_resultants(
            line, modes.columns_B, modes.values, spec.mass_form, (model.reference_node,)
        ),
        mode_labels=modes.labels,
        provenance=provenance,
    )


def mesh_warnings(model: BeamModel, modes: Modes) -> list[dict[str, str]]:
    """Warnings about a mesh too coarse for the modes that were kept."""
    error = frequency_error(model.line, modes.values, modes.columns_B, model.spec.mass_form)
    return coarse_mesh_warnings(modes.labels, error, model.spec.elements)


def _interface(
    name: str, row: int, nodes_B: Array, node_ids: IntArray, shapes_B: Array
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
    )
