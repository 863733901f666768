"""Inertia of a body from its mass matrix, whose elements are not known: invariants, second order.

- Three displacements per node and equal mass in all directions, M = M_s x 1: the position x_a is a
  displacement field of the elements, so sums with M_s are the integrals of the elements.
- Diagonal M: sums over nodes are exact.
- Coupled M with rotations: momentum and angular momentum of the modes, R' M X, and the inertia of
  the rigid body, R' M R, are exact; T11 and the symmetric part of T01 come from lumped masses.

With the gradients of two modes, the second-order strains are those of (grad u_i)' grad u_j. The
displacement h_ij cancels them as far as the body can: K h_ij = -g_ij, where g_ij . v is their work
on the stresses of v (docs/stiffening.md).
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from ...solver.package import Invariants, from_stations
from ...solver.package.body.package_schema import SecondOrder
from ..modes.reduced import square, turned
from ..modes.reference import Condition
from ..parts import own
from .free_body import FreeBody
from .imported_interfaces import Constrained, Link

SAME = 1e-9  # blocks of M relative to its largest entry


class Inertia(NamedTuple):
    """Invariants, lumped masses of the nodes, and which of the three forms M has."""

    invariants: Invariants
    node_mass: Array  # (n,) [kg]
    node_inertia: Array  # (n, 3, 3) [kg m2]
    form: str


def inertia(body: FreeBody, shapes: Array) -> Inertia:
    """Invariants of a body in SI units.

    Parameters
    ----------
    shapes : (m, n, 6) displacement and rotation of the nodes; zero where there is no dof
    """
    number = np.full((len(body.nodes), 6), -1)
    number[body.dof_node, body.dof_direction] = np.arange(len(body.dof_node))
    used = np.flatnonzero(number[:, 0] >= 0)
    blocks = [body.M[number[used, a]] for a in range(3)]
    Ms = blocks[0][:, number[used, 0]].tocsr()
    X = np.moveaxis(shapes, 0, 2)  # (n, 6, m)
    lumped = _lumped(body, number, used)
    M = own(body.M)
    off_diagonal = M - sp.diags(M.diagonal())
    if np.abs(off_diagonal.data).max(initial=0.0) <= SAME * np.abs(M.data).max():
        m, J = lumped
        sums = from_stations(m, body.nodes, X[:, :3], X[:, 3:], J, "lumped")
        return Inertia(sums, m, J, "diagonal mass: sums over the nodes")
    same = all(
        np.abs(own(blocks[a][:, number[used, b]] - float(a == b) * Ms).data).max(initial=0.0)
        <= SAME * np.abs(own(Ms).data).max()
        for a, b in np.ndindex(3, 3)
    )
    if (body.dof_direction < 3).all() and same:
        sums = _consistent(Ms, body.nodes[used], X[used, :3])
        return Inertia(sums, *lumped, "M = M_s x 1: consistent sums")
    return Inertia(_coupled(body, X, *lumped), *lumped, "coupled mass: T11 from lumped masses")


def _consistent(Ms: sp.csr_matrix, x: Array, phi: Array) -> Invariants:
    """Sums with the scalar mass matrix: x (n, 3), phi (n, 3, m)."""
    m = phi.shape[2]
    flat = phi.reshape(len(x), 3 * m)
    Mx, Mphi = Ms @ x, Ms @ flat
    T11 = (flat.T @ Mphi).reshape(3, m, 3, m).transpose(0, 2, 1, 3)
    return Invariants(
        mass=float((Ms @ np.ones(len(x))).sum()),
        S0_B=Mx.sum(axis=0),
        S_B=Mphi.sum(axis=0).reshape(3, m),
        T00_B=_symmetric(x.T @ Mx),
        T01_B=(x.T @ Mphi).reshape(3, 3, m),
        T11_B=(T11 + T11.transpose(1, 0, 3, 2)) / 2.0,
        J0_B=np.zeros((3, 3)),
        J_psi_B=np.zeros((3, m)),
        mass_form="consistent",
    )


def _symmetric(A: Array) -> Array:
    return np.asarray((A + A.T) / 2.0)


def _lumped(body: FreeBody, number: IntArray, used: IntArray) -> tuple[Array, Array]:
    """Nodal masses: the diagonal of M scaled to the total, which is never negative."""
    n = len(body.nodes)
    mass, J = np.zeros(n), np.zeros((n, 3, 3))
    diagonal = body.M.diagonal()
    R = body.rigid_motions()[:, :3]
    total = float(np.einsum("ni,ni->", R, body.M @ R)) / 3.0
    of_node = diagonal[number[used, :3]].mean(axis=1)
    mass[used] = of_node * (total / of_node.sum())
    for a in range(3):
        there = number[:, 3 + a] >= 0
        J[there, a, a] = diagonal[number[there, 3 + a]]
    return mass, J


def _coupled(body: FreeBody, X: Array, mass: Array, J: Array) -> Invariants:
    sums = from_stations(mass, body.nodes, X[:, :3], X[:, 3:], J, "lumped")
    R, U = body.rigid_motions(), X[body.dof_node, body.dof_direction]
    MR = body.M @ R
    momentum, rigid = MR.T @ U, R.T @ MR
    S0 = np.array([rigid[1, 5], rigid[2, 3], rigid[0, 4]])
    T = sums.T00_B
    T01 = sums.T01_B
    moment = np.array([T01[1, 2] - T01[2, 1], T01[2, 0] - T01[0, 2], T01[0, 1] - T01[1, 0]])
    return Invariants(
        mass=float(np.trace(rigid[:3, :3]) / 3.0),
        S0_B=S0,
        S_B=momentum[:3],
        T00_B=T,
        T01_B=T01,
        T11_B=sums.T11_B,
        J0_B=_symmetric(rigid[3:, 3:] - np.trace(T) * np.eye(3) + T),
        J_psi_B=momentum[3:] - moment,
        mass_form="lumped",
    )


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
    """Sums with the mass matrix of a body of three dofs per node.

    Parameters
    ----------
    body : three dofs per node, N = 3 n
    U : (N, m) modes
    h : (N, pairs) second-order displacements of the pairs of modes
    """
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
