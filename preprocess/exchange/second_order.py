"""Second-order displacements of the modes of a body with a mesh, for geometric stiffening.

With the gradients of two modes, the second-order strains are those of (grad u_i)' grad u_j. The
displacement h_ij cancels them as far as the body can: K h_ij = -g_ij, where g_ij . v is their work
on the stresses of v (docs/stiffening.md).
"""

from typing import NamedTuple

import numpy as np

from ...solver.math.arrays import Array
from ...solver.package.body.schema import SecondOrder
from ..modes.reduced import square, turned
from ..modes.reference import Condition
from .free_body import FreeBody
from .links import Constrained, Link


class Bent(NamedTuple):
    """Second-order motion of dofs and interfaces; pairs of modes i <= j."""

    h: Array  # (N, pairs)
    of_link: list[Array]  # (6, m, m) of each


def bent_body(
    body: FreeBody,
    every: list[Link],
    parts: Constrained,
    condition: Condition,
    U: Array,
    forces: Array,
) -> Bent:
    """Solve for the second-order displacements.

    Parameters
    ----------
    U : (N, m) motion of all dofs in the modes, three per node
    forces : (N, pairs) g of each pair
    """
    own = [_turned(body, link, U) for link in every]
    moved = np.zeros_like(forces)
    for t, link in zip(own, every, strict=True):
        moved += t if link.rigid else 0.0
    loads = -np.asarray(parts.T.T @ (forces + body.K @ moved))
    h = np.asarray(parts.T @ condition.static(loads, np.zeros_like(loads)).columns) + moved
    return Bent(
        h, [square(link.motion @ (h - t), U.shape[1]) for t, link in zip(own, every, strict=True)]
    )


def _turned(body: FreeBody, link: Link, U: Array) -> Array:
    """Second-order motion of the nodes of a link that turn with it, (N, pairs)."""
    moved = turned(np.asarray(link.motion @ U)[3:], body.nodes[link.rows] - link.position)
    out = np.zeros((len(body.nodes), *moved.shape[1:]))
    out[link.rows] = moved
    return out.reshape(-1, moved.shape[2])


def second_order_sums(body: FreeBody, U: Array, h: Array) -> SecondOrder:
    """Sums with the mass matrix of a body of three dofs per node."""
    m, x = U.shape[1], body.nodes
    Mh = np.asarray(body.M @ h)
    by_node = Mh.reshape(len(x), 3, -1)
    Z1 = np.einsum("na,nbp->abp", x, by_node).reshape(9, -1)
    G4 = h.T @ Mh  # (pairs, pairs)
    full = square(square(0.5 * (G4 + G4.T), m)[None], m)[0]
    return SecondOrder(
        Z0_B=square(by_node.sum(axis=0), m),
        Z1_B=square(Z1, m).reshape(3, 3, m, m),
        G3=square(U.T @ Mh, m),
        G4=full,
    )
