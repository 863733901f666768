"""Specification of a shell body, and its interfaces: their motion in the modes, and their nodes.

An interface at the centre of its group is the weighted mean of the group's nodes, for both
kinds of link: kind "average" of the package. An interface at another position has its own node
there, without cells and mass. The same holds for the two ends of a chord."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ....solver.math.rotations import vector_to_matrix
from ....solver.package.body.package_schema import Interface
from ....solver.package.common.cells import corner_areas
from ....solver.package.common.plain_data import SpecError, check_form
from ....solver.package.specification import ShellInterfaceTable, ShellSpecification
from ...beam.beam_specification import ModeSpec, Reference, read_modes, read_reference
from ...beam.beam_stations import Stations
from ...beam.beam_stations import mass_stations as line_stations
from ..model.links import Link, cross_matrix
from ..model.regions import Region
from ..model.stiffeners import Stiffener
from ..shell_cells import ShellMesh


@dataclass(frozen=True)
class ShellBodySpec:
    """A checked specification of a shell body.

    Attributes
    ----------
    body : name
    shell : specification of the shell, with links for the interfaces and the mass form
    interfaces : name and (3, 3) axes A_BI in body axes of each, in the order of the links
    reference : how the body frame is attached to the shell; its places are interfaces, by number
    modes : requested modes
    damping_ratio : of every mode, fraction of critical
    second_order : with second-order displacements, for geometric stiffening
    """

    body: str
    shell: dict[str, object]
    interfaces: dict[str, Array]
    reference: Reference
    modes: ModeSpec
    damping_ratio: float
    second_order: bool = False


def read_shell_body(spec: Mapping[str, object]) -> ShellBodySpec:
    """Read a specification (solver/package/specification.py).

    Raises
    ------
    SpecError : a key is unknown or missing, a value has another type, an interface does not exist.
    """
    table = check_form(spec, ShellSpecification)
    numbers = {name: float(i) for i, name in enumerate(table["interfaces"])}
    elements = {**table["shell"]["elements"], "mass_form": table["mass_form"]}
    links = {name: _link(entry) for name, entry in table["interfaces"].items()}
    return ShellBodySpec(
        body=table["body"],
        shell={**table["shell"], "elements": elements, "links": links},
        interfaces={
            name: vector_to_matrix(np.deg2rad(entry["rotation_deg"]))
            for name, entry in table["interfaces"].items()
        },
        reference=read_reference(table["reference"], numbers),
        modes=read_modes(table["modes"], numbers),
        damping_ratio=float(table["damping_ratio"]),
        second_order=table.get("second_order", False),
    )


def _link(table: ShellInterfaceTable) -> dict[str, object]:
    point = {"point": table["position"]} if "position" in table else {}
    return {"at": table["at"], "kind": table["link"], **point}


SAME_PLACE = 1e-9  # relative to the size of the mesh


class Places(NamedTuple):
    """Nodes of the package: those of the mesh in the order of its file, then those of
    interfaces."""

    nodes_B: Array  # (n, 3)                                [m]
    ids: IntArray  # (n,) unique
    own: dict[str, int]  # row of the node of an interface with its own node


def places(mesh: ShellMesh, links: Sequence[Link], shown: Sequence[int] = ()) -> Places:
    """The nodes of the package of a shell with these links.

    Parameters
    ----------
    mesh : of the shell
    links : in the order of the interfaces
    shown : numbers of links that have a node of their own in any case
    """
    apart = [
        link
        for number, link in enumerate(links)
        if np.linalg.norm(link.point_G - link.group.centre_G) > SAME_PLACE * mesh.size
        or link.kind == "section"  # it is not the mean of its nodes
        or (number in shown and len(link.group.nodes) > 1)
    ]
    nodes = [mesh.points_G, *(link.point_G[None] for link in apart)]
    tags = mesh.node_tags
    new = tags.max() + 1 + np.arange(len(apart))
    own = {link.name: mesh.n_node + i for i, link in enumerate(apart)}
    return Places(np.concatenate(nodes), np.concatenate([tags, new]), own)


def node_shapes(mesh: ShellMesh, links: Sequence[Link], places: Places, u: Array) -> Array:
    """Motion of the package's nodes, (m, n, 6).

    Parameters
    ----------
    mesh : of the shell
    links : in the order of the interfaces
    places : nodes of the package
    u : (n_dof, m) motion of all degrees of freedom
    """
    rows = u.reshape(len(u) // 6, 6, u.shape[1])
    number = {link.name: mesh.n_node + i for i, link in enumerate(links)}
    order = [*range(mesh.n_node), *(number[name] for name in places.own)]
    return np.ascontiguousarray(np.moveaxis(rows[order], 2, 0))


def interfaces(
    axes: Mapping[str, Array],
    mesh: ShellMesh,
    links: Sequence[Link],
    places: Places,
    u: Array,
    h: Array | None = None,
) -> tuple[Interface, ...]:
    """Interfaces of the package.

    Parameters
    ----------
    axes : (3, 3) interface axes A_BI in body axes by name
    links : those of the interfaces
    u : (n_dof, m) motion of all degrees of freedom, those of the links last
    h : (n_dof, m, m) second-order motion, or None
    """
    rows = u.reshape(len(u) // 6, 6, u.shape[1])
    bent = None if h is None else h.reshape(len(u) // 6, 6, *h.shape[1:])
    result = []
    for i, link in enumerate(links):
        motion = rows[mesh.n_node + i]
        nodes = link.group.nodes
        order = np.argsort(mesh.node_tags[nodes])
        ids, weights = mesh.node_tags[nodes][order], link.group.weights[order]
        if link.name in places.own:
            ids, weights = places.ids[[places.own[link.name]]], np.ones(1)
        result.append(
            Interface(
                name=link.name,
                kind="node" if len(ids) == 1 else "average",
                node_ids=ids,
                weights=weights / weights.sum(),
                position_B=link.point_G,
                A_BI=axes[link.name],
                phi_B=motion[:3],
                psi_B=motion[3:],
                H_B=None if bent is None else bent[mesh.n_node + i, :3],
                H_psi_B=None if bent is None else bent[mesh.n_node + i, 3:],
            )
        )
    return tuple(result)


# Mass stations of a shell body: positions of its mass and their motion in the modes.
#
# The inertia invariants of a body are sums over stations (solver/package/body/invariants.py). A
# fibre of the wall along the normal n, with the moments m0, m1, m2 of its density about the mesh,
# is a rigid piece: mass m0, centre at m1/m0 n from the mesh, rotary inertia about it (m2 - m1^2/m0)
# (1 - n n'). With consistent mass there are fibres at three points of each triangle and at four of
# each quadrilateral, which integrate the motions of their corners exactly. With lumped mass they
# are at its corners, and m2 also acts on the drilling rotation, as in `mass_work`. The sums then
# equal the mass matrix to round-off, with one exception: consistent mass also acts on the
# difference of the drilling rotation from that of the cell. This part is zero for rigid motions and
# has no momentum; only the modal mass includes it.


def mass_stations(
    mesh: ShellMesh, regions: Sequence[Region], stiffeners: Sequence[Stiffener], u: Array, form: str
) -> Stations:
    """Mass stations of a shell and their motion. Paper: Eq. (31).

    Parameters
    ----------
    u : (n, 6, m) displacements and rotations of the mesh's nodes in m modes, body axes [m, rad]
    form : "consistent" or "lumped", that of the mass matrix

    Raises
    ------
    SpecError : the mass of a stiffener is not that of rigid slices.
    """
    parts = [_of_region(mesh, region, u, form) for region in regions]
    for stiffener in stiffeners:
        ends = stiffener.carried @ u.reshape(-1, u.shape[2])
        try:
            parts.append(line_stations(stiffener.line, ends, form))
        except ValueError as error:
            raise SpecError(f"shell.stiffeners.{stiffener.name}: {error}") from error
    return Stations.joined(parts)


def nodal_mass(
    mesh: ShellMesh, regions: Sequence[Region], stiffeners: Sequence[Stiffener]
) -> tuple[Array, Array]:
    """Lumped mass of each node, (n,) [kg], and inertia about the node, (n, 3, 3) [kg m2].

    Parameters
    ----------
    mesh : of the shell, n nodes
    regions : with their laminates
    stiffeners : on curves of the mesh
    """
    mass, rotary = np.zeros(mesh.n_node), np.zeros(mesh.n_node)
    for region in regions:
        m0, _, m2 = region.stiffness.mass
        nodes, share = corner_areas(mesh.points_G, region.nodes)
        area = np.bincount(nodes, weights=share, minlength=mesh.n_node)
        mass += m0 * area
        rotary += m2 * area
    inertia = rotary[:, None, None] * np.eye(3)
    for stiffener in stiffeners:
        M = stiffener.mass("lumped")
        mass += M.diagonal()[::6]
        for i, j in np.ndindex(3, 3):
            inertia[:, i, j] += M[3 + i :: 6, 3 + j :: 6].diagonal()
    return mass, inertia


def _of_region(mesh: ShellMesh, region: Region, u: Array, form: str) -> Stations:
    m0, m1, m2 = region.stiffness.mass
    cells, count = region.nodes, region.nodes.shape[1]
    consistent = form == "consistent"
    N = region.geometry.interpolation if consistent else np.eye(count)
    corners = u[cells]  # (c, 3|4, 6, m)
    flat = corners.reshape(len(cells), count, 6 * u.shape[2])
    motion = (N @ flat).reshape(count * len(cells), *u.shape[1:])
    normal = np.repeat(region.geometry.A_GE[:, :, 2], count, axis=0)
    weight = region.geometry.weight.ravel()
    if not consistent:
        weight = corner_areas(mesh.points_G, cells)[1]
    across = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    inertia = (m2 - m1**2 / m0) * across
    if form == "lumped":
        inertia = m2 * np.eye(3) - m1**2 / m0 * across
    arm = m1 / m0 * normal
    phi, psi = motion[:, :3], motion[:, 3:]
    if m1 != 0.0:
        phi = phi - cross_matrix(arm) @ psi
    return Stations(
        m=m0 * weight,
        x_B=(N @ mesh.points_G[cells]).reshape(-1, 3) + arm,
        phi_B=phi,
        psi_B=psi,
        J_B=weight[:, None, None] * inertia,
    )
