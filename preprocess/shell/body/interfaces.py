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
from ....solver.package.common.plain_data import check_form
from ....solver.package.specification import ShellInterfaceTable, ShellSpecification
from ...beam.beam_specification import ModeSpec, Reference, read_modes, read_reference
from ..model.links import Link
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
