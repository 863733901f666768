"""Links and stiffeners of the second formulation (second_route.py).

Unknowns behind those of the surface are the rotations of the nodes of stiffeners and the motions of
the points of links. Linear equations x = T y make some unknowns depend on others:

- a stiffener has the quadratic displacement of the edge and a rotation that is linear between its
  nodes; the rotation of the surface in the middle of the edge is the mean of those of its ends;
- a rigid link moves all places of its group, and their rotations, with its point;
- the point of another link follows integrals over its group: F'u with six fields F of forces that
  have unit resultants. Those of an average link are rigid motions, those of a section link the
  stresses of Saint-Venant in the walls, from the warping of the section.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import sides
from ..model.links import Link
from ..model.problem import ShellProblem
from ..model.stiffeners import Stiffener

FREE = 1e-8  # second moment about an axis over the largest that does not determine a rotation


class Spread(NamedTuple):
    """What a group takes displacements and rotations with.

    Attributes
    ----------
    at : (p,) places: nodes, then middles of sides
    weights : (p,) integrals of their functions; 1 for a point [m, m2, -]
    sides, turn_weights : (t,) sides with rotations, and their weights
    """

    at: IntArray
    weights: Array
    sides: IntArray
    turn_weights: Array


class Route(Protocol):
    """What is used of `SecondRoute`."""

    places: Array
    sides: IntArray
    u: IntArray
    turns: IntArray

    def spread(self, names: Any) -> Spread:
        """Places of groups."""

    def numbers(self, ends: IntArray) -> IntArray:
        """Rows of `sides`."""


class Parts:
    """Unknowns, equations and matrices that links and stiffeners add to a surface.

    Attributes
    ----------
    size : number of all unknowns
    turns : (n, 3) unknowns of the rotation of each node, -1 without a stiffener
    points : (l, 6) unknowns of the motion of each link's point
    T : (size, size) all unknowns from the independent ones, without columns for the others
    dependent : (size,) booleans
    K, M : (size, size) of the stiffeners
    """

    def __init__(self, route: Route, problem: ShellProblem, size: int) -> None:
        self.turns = np.full((problem.mesh.n_node, 3), -1)
        held = np.unique([ends for s in problem.stiffeners for ends in s.ends.ravel()])
        held = held.astype(np.int64)
        self.turns[held] = size + np.arange(3 * len(held)).reshape(-1, 3)
        size += 3 * len(held)
        self.points = size + np.arange(6 * len(problem.links)).reshape(-1, 6)
        self.size = size + self.points.size
        self.K, self.M = (sp.csr_matrix((self.size, self.size)) for _ in range(2))
        self.T, self.dependent = sp.identity(self.size, format="csr"), np.zeros(self.size, bool)
        for link, point in zip(problem.links, self.points, strict=True):
            if link.kind == "rigid":
                self._carry(route, problem, link, point)
        for stiffener in problem.stiffeners:
            self._beam(route, stiffener)
        for link, point in zip(problem.links, self.points, strict=True):
            if link.kind != "rigid":
                rows, fields = _fields(route, problem, link)
                self._depend(np.repeat(point, len(rows)), np.tile(rows, 6), fields.T.ravel())

    def _depend(self, rows: IntArray, columns: IntArray, values: Array) -> None:
        """Replace unknowns by sums of others."""
        self.dependent[rows] = True
        keep = np.ones(self.size)
        keep[rows] = 0.0
        step = sp.csr_matrix((values, (rows, columns)), shape=(self.size, self.size))
        self.T = sp.csr_matrix((sp.diags(keep) + step) @ self.T)

    def _carry(self, route: Route, problem: ShellProblem, link: Link, point: IntArray) -> None:
        group = route.spread(problem.spec["links"][link.name]["at"])
        at = np.unique(group.at)
        R = rigid(route.places[at] - link.point_G)
        rows, columns = np.repeat(route.u[at], 6, axis=1), np.tile(point, (len(at), 3))
        self._depend(rows.ravel(), columns.ravel(), R.ravel())
        nodes = at[at < len(self.turns)]
        turned = [route.turns[np.unique(group.sides)], self.turns[nodes[self.turns[nodes, 0] >= 0]]]
        rows = np.concatenate(turned)
        self._depend(rows.ravel(), np.tile(point[3:], len(rows)), np.ones(rows.size))

    def _beam(self, route: Route, beam: Stiffener) -> None:
        middle = route.numbers(beam.ends)
        nodes = [*beam.ends.T, len(self.turns) + middle]
        ends = self.turns[beam.ends]  # (l, 2, 3)
        rows = np.repeat(route.turns[middle], 2, axis=0)
        self._depend(rows.ravel(), ends.reshape(-1, 3).ravel(), np.full(rows.size, 0.5))
        unknowns = np.concatenate([*(route.u[n] for n in nodes), ends[:, 0], ends[:, 1]], axis=1)
        A, L = np.swapaxes(beam.A_GE, 1, 2), beam.length[:, None, None]
        arm = -crossed(np.array([0.0, *beam.offset])) @ A  # of a rotation, at the reference line
        lean = crossed(np.array([1.0, 0.0, 0.0])) @ A
        none = np.zeros_like(A)
        K = M = np.zeros((len(L), 15, 15))
        for x, w in zip(*np.polynomial.legendre.leggauss(3), strict=True):
            s = 0.5 * (1.0 + x)
            N, dN, H = _line(s)[0], _line(s)[1], (1.0 - s, s)
            dH = -1.0 / L, 1.0 / L
            moved = [n * A for n in N] + [h * arm for h in H]
            strained = [n / L * A for n in dN]
            strained += [d * arm + h * lean for h, d in zip(H, dH, strict=True)]
            B = np.block([strained, [none] * 3 + [d * A for d in dH]])
            D = np.block([moved, [none] * 3 + [h * A for h in H]])
            K = K + 0.5 * w * L * (np.swapaxes(B, 1, 2) @ beam.K @ B)
            M = M + 0.5 * w * L * (np.swapaxes(D, 1, 2) @ beam.M @ D)
        place = np.repeat(unknowns, 15, axis=1).ravel(), np.tile(unknowns, 15).ravel()
        shape = (self.size, self.size)
        self.K = self.K + sp.csr_matrix((K.ravel(), place), shape=shape)
        self.M = self.M + sp.csr_matrix((M.ravel(), place), shape=shape)


def crossed(a: Array) -> Array:
    """a~ with a~ b = a x b, (..., 3, 3)."""
    return np.swapaxes(np.cross(a[..., None, :], np.eye(3)), -1, -2)


def rigid(arms: Array) -> Array:
    """Displacements of places by a motion of the point that `arms` (p, 3) begin at, (p, 3, 6)."""
    return np.concatenate([np.broadcast_to(np.eye(3), (len(arms), 3, 3)), -crossed(arms)], axis=2)


def _line(s: float) -> tuple[Array, Array]:
    """Quadratic functions of the ends and the middle of a line at 0 < s < 1, and their slopes."""
    N = [(1.0 - s) * (1.0 - 2.0 * s), s * (2.0 * s - 1.0), 4.0 * s * (1.0 - s)]
    return np.array(N), np.array([4.0 * s - 3.0, 4.0 * s - 1.0, 4.0 - 8.0 * s])


def _fields(route: Route, problem: ShellProblem, link: Link) -> tuple[IntArray, Array]:
    """Unknowns (q,) and forces on them (q, 6) of unit resultants at the point of a link."""
    group = route.spread(problem.spec["links"][link.name]["at"])
    at, number = np.unique(group.at, return_inverse=True)
    weights = np.bincount(number.ravel(), weights=group.weights)
    arms, turns = route.places[at] - link.point_G, route.turns[group.sides]
    R = rigid(arms).reshape(-1, 6)
    # a rotation of the point turns all sides
    R = np.concatenate([R, np.tile(np.eye(6)[3:], (len(turns), 1))])
    if link.kind == "section":
        F = _saint_venant(route, problem, link, at, group.sides)
    else:
        F = np.repeat(weights, 3)[:, None] * R[: 3 * len(at)]
        centre = weights @ arms / weights.sum()
        inertia = np.einsum("p,pij,pik->jk", weights, *[crossed(arms - centre)] * 2)
        value, axes = np.linalg.eigh(inertia)
        least = FREE * max(value[-1], FREE * weights.sum() * np.square(arms).sum(axis=1).max())
        free = axes[:, value <= least] @ axes[:, value <= least].T
        by_turns = np.repeat(group.turn_weights, 3)[:, None] * np.tile(free, (len(turns), 1))
        F = np.concatenate([F, np.pad(by_turns, ((0, 0), (3, 0)))])
    rows = np.concatenate([route.u[at].ravel(), turns.ravel()])
    return rows, F @ np.linalg.inv(R.T @ F)


def _saint_venant(
    route: Route, problem: ShellProblem, link: Link, at: IntArray, own: IntArray
) -> Array:
    """Forces on places and moments on sides of extension, two bendings, torsion, two shears."""
    n = problem.mesh.n_node
    i, j = np.searchsorted(at, route.sides[own].T)
    ends = np.stack([i, j, np.searchsorted(at, n + own)], axis=1)  # (s, 3)
    X = route.places[at] - link.point_G
    x = np.linalg.svd(X - X.mean(axis=0))[2][2]  # normal to the plane of the section
    t = X[j] - X[i]
    L = np.linalg.norm(t, axis=1)
    t /= L[:, None]
    E, G, GJ = np.zeros((3, len(own)))
    for region in problem.regions:
        pairs, cell = sides(region.nodes)
        for row, side in zip(*np.nonzero(route.numbers(pairs) == own[:, None])[::-1], strict=True):
            c, s = region.geometry.A_GE[cell[row], :, :2].T @ x
            along = np.array([c * c, s * s, c * s])
            shear = np.array([-2.0 * c * s, 2.0 * c * s, c * c - s * s])
            flexible, bent = (np.linalg.inv(a) for a in (region.stiffness.A, region.stiffness.D))
            E[side] += 1.0 / (along @ flexible @ along)
            G[side] += 1.0 / (shear @ flexible @ shear)
            GJ[side] += 4.0 / (shear @ bent @ shear)
    k, forces = len(at), np.zeros((len(at), 3, 6))
    stiff, loads, flows = np.zeros((k, k)), np.zeros((k, 3)), []
    y = np.linalg.svd(x[None])[2][1:] @ X.T  # coordinates in the plane, (2, k)
    for gauss, w in zip(*np.polynomial.legendre.leggauss(3), strict=True):
        N, slope = _line(0.5 * (1.0 + gauss))
        slope = slope / L[:, None]
        swept = np.cross(np.einsum("k,ski->si", N, X[ends]), t) @ x
        normal = 0.5 * w * L * E * np.stack([np.ones(len(L)), *(y[:, ends] @ N)])  # (3, s)
        nodal = np.zeros((k, 3))
        np.add.at(nodal, ends, np.einsum("as,k->ska", normal, N))
        forces[:, :, :3] += nodal[:, None] * x[:, None]
        loads[:, 1:] += nodal[:, 1:]
        np.add.at(loads[:, 0], ends, -(0.5 * w * L * G * swept)[:, None] * slope)
        part = (0.5 * w * L * G)[:, None, None] * slope[:, :, None] * slope[:, None]
        np.add.at(stiff, (ends[:, :, None], ends[:, None]), part)
        flows.append((w, N, slope, swept))
    # bending about axes through the centre of stiffness: no resultant along x
    mean = loads[:, 1:].sum(axis=0) / forces[:, :, 0].sum(axis=0).dot(x)
    loads[:, 1:] -= np.outer(forces[:, :, 0] @ x, mean)
    warping = np.linalg.lstsq(stiff, loads, rcond=None)[0]
    for w, N, slope, swept in flows:
        q = np.einsum("sk,ska->sa", slope, warping[ends])
        q[:, 0] += swept
        force = (0.5 * w * L * G)[:, None] * q
        np.add.at(forces[..., 3:], ends, np.einsum("sa,k,si->skia", force, N, t))
    moments = np.zeros((len(own), 3, 6))
    moments[:, :, 3] = (GJ * L)[:, None] * x
    return np.concatenate([forces.reshape(-1, 6), moments.reshape(-1, 6)])
