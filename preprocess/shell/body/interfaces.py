"""Interfaces of a shell body: their motion in the modes, and their nodes.

An interface at the centre of its group is the weighted mean of the group's nodes, for both
kinds of link: kind "average" of the package. An interface at another position has its own node
there, without cells and mass. The same holds for the two ends of a chord.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ....solver.package.body.schema import Interface
from ..mesh.body_spec import ShellInterface
from ..mesh.mesh import ShellMesh
from ..model.links import Link

SAME_PLACE = 1e-9  # relative to the size of the mesh


class Places(NamedTuple):
    """Nodes of the package: those of the mesh in the order of its file, then those of
    interfaces."""

    nodes_B: Array  # (n, 3)                                [m]
    ids: IntArray  # (n,) unique
    own: dict[str, int]  # row of the node of an interface with its own node


def places(mesh: ShellMesh, links: Sequence[Link], shown: Sequence[int] = ()) -> Places:
    """The nodes of the package of a shell with these links; links in `shown` have their own
    node."""
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


def node_shapes(mesh: ShellMesh, links: Sequence[Link], found: Places, u: Array) -> Array:
    """Motion of the package's nodes, (m, n, 6), from that of all degrees of freedom (n_dof, m)."""
    rows = u.reshape(len(u) // 6, 6, u.shape[1])
    number = {link.name: mesh.n_node + i for i, link in enumerate(links)}
    order = [*range(mesh.n_node), *(number[name] for name in found.own)]
    return np.ascontiguousarray(np.moveaxis(rows[order], 2, 0))


def interfaces(
    requested: Sequence[ShellInterface],
    mesh: ShellMesh,
    links: Sequence[Link],
    found: Places,
    u: Array,
    h: Array | None = None,
) -> tuple[Interface, ...]:
    """Interfaces of the package.

    Parameters
    ----------
    requested, links : in the same order
    u : (n_dof, m) motion of all degrees of freedom, those of the links last
    h : (n_dof, m, m) second-order motion, or None
    """
    rows = u.reshape(len(u) // 6, 6, u.shape[1])
    bent = None if h is None else h.reshape(len(u) // 6, 6, *h.shape[1:])
    result = []
    for i, (interface, link) in enumerate(zip(requested, links, strict=True)):
        motion = rows[mesh.n_node + i]
        nodes = link.group.nodes
        order = np.argsort(mesh.node_tags[nodes])
        ids, weights = mesh.node_tags[nodes][order], link.group.weights[order]
        if link.name in found.own:
            ids, weights = found.ids[[found.own[link.name]]], np.ones(1)
        result.append(
            Interface(
                name=link.name,
                kind="node" if len(ids) == 1 else "average",
                node_ids=ids,
                weights=weights / weights.sum(),
                position_B=link.point_G,
                A_BI=interface.A_BI,
                phi_B=motion[:3],
                psi_B=motion[3:],
                H_B=None if bent is None else bent[mesh.n_node + i, :3],
                H_psi_B=None if bent is None else bent[mesh.n_node + i, 3:],
            )
        )
    return tuple(result)
