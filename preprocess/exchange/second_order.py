"""Second-order displacements of the modes of a body with a mesh, for geometric stiffening.

With the gradients of two modes, the second-order strains are those of (grad u_i)' grad u_j. The
displacement h_ij cancels them as far as the body can: K h_ij = -g_ij, where g_ij . v is their work
on the stresses of v (docs/stiffening.md).
"""

from typing import NamedTuple

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.schema import SecondOrder
from ..modes import Condition
from .free_body import FreeBody
from .links import Constrained, Link


class Bent(NamedTuple):
    """Second-order motion of dofs and interfaces; pairs of modes i <= j."""

    h: Array  # (N, pairs)
    of_link: list[Array]  # (6, m, m) of each


def pairs(m: int) -> tuple[IntArray, IntArray]:
    """Modes of each pair i <= j."""
    return np.triu_indices(m)


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
    turned = np.zeros_like(forces)
    for t, link in zip(own, every, strict=True):
        turned += t if link.rigid else 0.0
    loads = -np.asarray(parts.T.T @ (forces + body.K @ turned))
    h = np.asarray(parts.T @ condition.static(loads, np.zeros_like(loads)).columns) + turned
    return Bent(
        h, [_square(link.motion @ (h - t), U.shape[1]) for t, link in zip(own, every, strict=True)]
    )


def _turned(body: FreeBody, link: Link, U: Array) -> Array:
    """Second-order motion of the nodes of a link that turn with it, (N, pairs)."""
    turn = np.asarray(link.motion @ U)[3:].T  # (m, 3)
    i, j = pairs(U.shape[1])
    d = (body.nodes[link.rows] - link.position)[:, None]
    moved = 0.5 * (
        np.cross(turn[i], np.cross(turn[j], d)) + np.cross(turn[j], np.cross(turn[i], d))
    )
    out = np.zeros((len(body.nodes), 3, len(i)))
    out[link.rows] = moved.transpose(0, 2, 1)
    return out.reshape(-1, len(i))


def _square(values: Array, m: int) -> Array:
    """Values (a, pairs) as symmetric tables (a, m, m)."""
    i, j = pairs(m)
    out = np.empty((len(values), m, m))
    out[:, i, j] = out[:, j, i] = values
    return out


def second_order_sums(body: FreeBody, U: Array, h: Array) -> SecondOrder:
    """Sums with the mass matrix of a body of three dofs per node."""
    m, x = U.shape[1], body.nodes
    Mh = np.asarray(body.M @ h)
    by_node = Mh.reshape(len(x), 3, -1)
    Z1 = np.einsum("na,nbp->abp", x, by_node).reshape(9, -1)
    i, j = pairs(m)
    G4 = h.T @ Mh  # (pairs, pairs)
    whole = _square(0.5 * (G4 + G4.T), m)
    full = np.empty((m, m, m, m))
    full[i, j] = full[j, i] = whole
    return SecondOrder(
        Z0_B=_square(by_node.sum(axis=0), m),
        Z1_B=_square(Z1, m).reshape(3, 3, m, m),
        G3=_square(U.T @ Mh, m),
        G4=full,
    )
