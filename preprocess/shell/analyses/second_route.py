"""Laminated shells by a second formulation, which judges the elements: `plymotion shell --verify`.

Quadratic displacement and Crouzeix-Raviart rotations on flat triangles, as a UFL form assembled by
DOLFINx (the pair of Campello, Pimenta and Wriggers, Comput. Mech. 31 (2003) 505). It shares no
formula with the elements: no discrete shear constraint, no drilling dof in the membrane. Jumps of
the rotations have a stiffness (Hansbo and Larson, Math. Model. Numer. Anal. 37 (2003) 63). Of the
engine it takes the mesh, the stiffness of the laminates and their reference directions.

Unknowns behind those of the surface are the rotations of the nodes of stiffeners and the motions of
the points of links. Linear equations x = T y make some unknowns depend on others:

- a stiffener has the quadratic displacement of the edge and a rotation that is linear between its
  nodes; the rotation of the surface in the middle of the edge is the mean of those of its ends, and
  a rotation of its own about the normal;
- a rigid link moves all places of its group, and their rotations, with its point;
- the point of another link follows integrals over its group: F'u with six fields F of forces that
  have unit resultants. Those of an average link are rigid motions, those of a section link the
  stresses of Saint-Venant in the walls, from the warping of the section.
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
import ufl
from scipy.spatial import cKDTree

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import corner_counts, sides
from ... import fenicsx
from ...fenicsx.spaces import (
    assembled,
    cell_function,
    dof_coordinates,
    dolfinx_mesh,
    function_space,
    original_cells,
    p2_cr_element,
    quiet,
)
from ..groups import cell_directions
from ..model.links import Link
from ..model.shell_problem import ShellProblem
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

    def __init__(self, route: "SecondRoute", problem: ShellProblem, size: int) -> None:
        self.turns = np.full((problem.mesh.n_node, 3), -1)
        held = np.unique([ends for s in problem.stiffeners for ends in s.ends.ravel()])
        held = held.astype(np.int64)
        self.turns[held] = size + np.arange(3 * len(held)).reshape(-1, 3)
        size += 3 * len(held)
        ends = size + np.cumsum([0, *(len(s.ends) for s in problem.stiffeners)])
        spins = [np.arange(*pair) for pair in pairwise(ends)]
        size = int(ends[-1])
        self.points = size + np.arange(6 * len(problem.links)).reshape(-1, 6)
        self.size = size + self.points.size
        self.K, self.M = (sp.csr_matrix((self.size, self.size)) for _ in range(2))
        self.T, self.dependent = sp.identity(self.size, format="csr"), np.zeros(self.size, bool)
        for link, point in zip(problem.links, self.points, strict=True):
            if link.kind == "rigid":
                self._carry(route, problem, link, point)
        for stiffener, spin in zip(problem.stiffeners, spins, strict=True):
            self._beam(route, stiffener, spin)
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

    def _carry(
        self, route: "SecondRoute", problem: ShellProblem, link: Link, point: IntArray
    ) -> None:
        group = route.spread(problem.spec["links"][link.name]["at"])
        at = np.unique(group.at)
        R = rigid(route.places[at] - link.point_G)
        rows, columns = np.repeat(route.u[at], 6, axis=1), np.tile(point, (len(at), 3))
        self._depend(rows.ravel(), columns.ravel(), R.ravel())
        nodes = at[at < len(self.turns)]
        turned = [route.turns[np.unique(group.sides)], self.turns[nodes[self.turns[nodes, 0] >= 0]]]
        rows = np.concatenate(turned)
        self._depend(rows.ravel(), np.tile(point[3:], len(rows)), np.ones(rows.size))

    def _beam(self, route: "SecondRoute", beam: Stiffener, spin: IntArray) -> None:
        middle = route.numbers(beam.ends)
        nodes = [*beam.ends.T, len(self.turns) + middle]
        ends = self.turns[beam.ends]  # (l, 2, 3)
        own, side = np.unique(route.of_cells, return_index=True)
        normal = route.normal[side[np.searchsorted(own, middle)] // 3]
        rows = route.turns[middle]
        carried = self.dependent[rows[:, 0]]
        self._depend(spin[carried], np.zeros(0, int), np.zeros(0))
        columns = np.concatenate([ends, np.repeat(spin[:, None, None], 3, axis=2)], axis=1)
        values = np.concatenate([np.full(ends.shape, 0.5), normal[:, None]], axis=1)
        rows = np.broadcast_to(rows[:, None], columns.shape)
        self._depend(rows.ravel(), columns.ravel(), values.ravel())
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


def _fields(route: "SecondRoute", problem: ShellProblem, link: Link) -> tuple[IntArray, Array]:
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
    route: "SecondRoute", problem: ShellProblem, link: Link, at: IntArray, own: IntArray
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


DRILLING = 1.0  # stiffness of the turn about the normal against that of the surface, over A66


class SecondRoute:
    """Stiffness and mass of a shell, its links and stiffeners.

    Attributes
    ----------
    cells : (c, 3) triangles; a quadrilateral is two of them
    rows : (c,) their cells in the mesh of the problem
    normal : (c, 3) unit normals, reversed where the region is flipped
    sides : (s, 2) sides of the triangles, nodes ascending
    places : (n + s, 3) nodes and middles of sides [m]
    u : (n + s, 3) unknowns of the displacement there
    turns : (s, 3) unknowns of the rotation at middles of sides
    parts : unknowns of links and stiffeners, and equations between all of them
    K, M : stiffness and mass of all unknowns [N/m, N, N m; kg, kg m, kg m2]
    """

    def __init__(self, problem: ShellProblem) -> None:
        self.problem, mesh = problem, problem.mesh
        self.points = mesh.points_G
        four = np.flatnonzero(corner_counts(mesh.cells) == 4)
        self.cells = np.concatenate([mesh.cells[:, :3], mesh.cells[four][:, [0, 2, -1]]])
        self.rows = np.concatenate([np.arange(len(mesh.cells)), four])
        pairs = np.sort(self.cells[:, [[1, 2], [0, 2], [0, 1]]], axis=2)
        self.sides, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
        self.of_cells = number.reshape(-1, 3)  # side opposite to each corner
        corners = self.points[self.cells]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.area = 0.5 * np.linalg.norm(normal, axis=1)
        first, flipped, laminates = _of_mesh(problem)
        self.normal = normal * (flipped[self.rows] / (2.0 * self.area))[:, None]
        first = first[self.rows]
        first = first - self.normal * np.einsum("ci,ci->c", first, self.normal)[:, None]
        first /= np.linalg.norm(first, axis=1)[:, None]
        region = np.zeros(len(self.cells), dtype=np.int64)
        plain = fenicsx.PlainMesh(self.points, self.cells, "triangle", 1, region, ("all",))
        self.mesh = dolfinx_mesh(plain)
        own = original_cells(self.mesh)

        def of_cells(values: Any) -> Any:
            return cell_function(self.mesh, np.asarray(values)[own])

        # rows e1, e2, e3 of one tensor: the old UFL has no piecewise constant vectors in space
        axes = np.stack([first, np.cross(self.normal, first), self.normal], axis=1)
        A_EG = of_cells(axes)
        self.axes = [ufl.as_vector([A_EG[i, j] for j in range(3)]) for i in range(3)]
        A, B, D, Ds = (
            of_cells([getattr(laminates[row], name) for row in self.rows])
            for name in ("A", "B", "D", "Ds")
        )
        mass = [of_cells([laminates[row].mass[n] for row in self.rows]) for n in range(3)]
        self.space = function_space(self.mesh, p2_cr_element(self.mesh))
        self.K, self.M = (assembled(form) for form in self._forms(A, B, D, Ds, mass))
        self.places = np.concatenate([self.points, self.points[self.sides].mean(axis=1)])
        self.u = self._unknowns(0, self.places)
        self.turns = self._unknowns(1, self.places[len(self.points) :])
        self.parts = Parts(self, problem, self.K.shape[0])
        for name in ("K", "M"):
            matrix = sp.csr_matrix(getattr(self, name))
            matrix.resize(self.parts.size, self.parts.size)
            setattr(self, name, matrix + getattr(self.parts, name))

    def _forms(self, A: Any, B: Any, D: Any, Ds: Any, mass: Any) -> tuple[Any, Any]:
        (u, theta), (du, dtheta) = (
            ufl.split(make(self.space)) for make in (ufl.TrialFunction, ufl.TestFunction)
        )
        e, k, g, d = self._strains(u, theta)
        de, dk, dg, dd = self._strains(du, dtheta)
        energy = ufl.inner(A * e + B * k, de) + ufl.inner(B * e + D * k, dk)
        energy += ufl.inner(Ds * g, dg) + DRILLING * A[2, 2] * d * dd
        beta, dbeta = (ufl.cross(t, self.axes[2]) for t in (theta, dtheta))
        inertia = mass[0] * ufl.inner(u, du) + mass[2] * ufl.inner(theta, dtheta)
        inertia += mass[1] * (ufl.inner(u, dbeta) + ufl.inner(beta, du))
        dx, dx_mass = (
            ufl.Measure("dx", domain=self.mesh, metadata={"quadrature_degree": n}) for n in (2, 4)
        )
        # Rotations that fit together in the middles of sides only bend without energy where no
        # shear strain ties them, as those of an offset laminate (no Korn inequality).
        dS = ufl.Measure("dS", domain=self.mesh, metadata={"quadrature_degree": 2})
        size = ufl.avg(ufl.Circumradius(self.mesh))
        jumps = ufl.inner(ufl.jump(theta), ufl.jump(dtheta))
        return energy * dx + ufl.avg(D[2, 2]) / size * jumps * dS, inertia * dx_mass

    def _strains(self, u: Any, theta: Any) -> tuple[Any, Any, Any, Any]:
        """Membrane strain, curvature (with doubled shear), transverse shear, drilling."""
        e1, e2, e3 = self.axes
        beta = ufl.cross(theta, e3)

        def derivative(field: Any, i: Any, j: Any) -> Any:
            return ufl.dot(i, ufl.dot(ufl.grad(field), j))

        shear = derivative(u, e1, e2) + derivative(u, e2, e1)
        in_plane = ufl.as_vector([derivative(u, e1, e1), derivative(u, e2, e2), shear])
        # e3 is constant in a cell, so the gradient of theta x e3 is that of theta
        turning = ufl.as_tensor(
            [[ufl.cross(theta.dx(j), e3)[i] for j in range(3)] for i in range(3)]
        )
        curvature = [ufl.dot(i, ufl.dot(turning, j)) for i, j in ((e1, e1), (e2, e2))]
        twist = ufl.dot(e1, ufl.dot(turning, e2)) + ufl.dot(e2, ufl.dot(turning, e1))
        across = [ufl.dot(beta, e) + derivative(u, e3, e) for e in (e1, e2)]
        drill = ufl.dot(theta, e3) - 0.5 * (derivative(u, e2, e1) - derivative(u, e1, e2))
        return in_plane, ufl.as_vector([*curvature, twist]), ufl.as_vector(across), drill

    def _unknowns(self, field: int, places: Array) -> IntArray:
        """Unknowns (k, 3) of the components of a field at places (k, 3)."""
        numbers_of_unknowns = np.empty((len(places), 3), dtype=np.int64)
        for row in range(3):
            with quiet():
                space, numbers = self.space.sub(field).sub(row).collapse()
            nearest = cKDTree(dof_coordinates(space)).query(places)[1]
            numbers_of_unknowns[:, row] = np.ravel(numbers)[nearest]
        return numbers_of_unknowns

    def numbers(self, ends: IntArray) -> IntArray:
        """Rows of `sides` of pairs of nodes (k, 2)."""
        n = len(self.points)
        low, high = np.sort(ends, axis=1).T
        return np.searchsorted(self.sides @ np.array([n, 1]), low * n + high)

    def spread(self, names: Any) -> Spread:
        """Places and weights of physical groups, one name or several; None: all cells."""
        mesh, spreads = self.problem.mesh, []
        for name in names if isinstance(names, list | tuple) else [names]:
            if name in mesh.marks:
                nodes = mesh.marks[name]
                near = np.flatnonzero(np.isin(self.sides, nodes).any(axis=1))
                spreads.append(Spread(nodes, np.ones(len(nodes)), near, np.ones(len(near))))
                continue
            if name in mesh.curves:
                ends = mesh.curves[name]
                size = np.linalg.norm(np.diff(self.points[ends], axis=1)[:, 0], axis=1)
                rows, corner = self.numbers(ends)[:, None], 1.0 / 6.0
            else:
                inside = np.ones(len(self.rows), dtype=bool)
                if name is not None:
                    inside = mesh.region[self.rows] == mesh.regions.index(name)
                ends, rows, size = self.cells[inside], self.of_cells[inside], self.area[inside]
                corner = 0.0
            count = rows.shape[1]
            middle = size * (1.0 - corner * ends.shape[1] * (count == 1)) / count
            weights = np.repeat(corner * size, ends.shape[1]), np.repeat(middle, count)
            at = np.concatenate([ends.ravel(), len(self.points) + rows.ravel()])
            turned = np.repeat(size / count, count)
            spreads.append(Spread(at, np.concatenate(weights), rows.ravel(), turned))
        return Spread(*(np.concatenate(part) for part in zip(*spreads, strict=True)))

    def solve(self, rhs: Array, fixed: Array, given: Array) -> Array:
        """All unknowns (k,) under a right-hand side.

        Parameters
        ----------
        rhs : (k,) nodal forces and moments
        fixed : (k,) booleans: held unknowns
        given : (k,) displacements of these, zero elsewhere
        """
        T, free = self.parts.T, self._free(fixed)
        solution = np.where(self.parts.dependent, 0.0, given)
        load = T.T @ (rhs - self.K @ (T @ solution))
        solution[free] = fenicsx.cholesky(self._part(self.K, free)).solve(load[free])
        return np.asarray(T @ solution)

    def eigenvalues(self, count: int, fixed: Array, target: float = 0.0) -> Array:
        """Squared circular frequencies (count,) [rad2/s2], nearest to a target.

        Parameters
        ----------
        count : requested
        fixed : (k,) booleans: held unknowns
        target : [rad2/s2]; below zero where motions have no stiffness
        """
        free = self._free(fixed)
        K, M = self._part(self.K, free), self._part(self.M, free)
        return fenicsx.eigenpairs(K, M, count, target=target)[0]

    def _free(self, fixed: Array) -> IntArray:
        return np.flatnonzero((fixed == 0) & ~self.parts.dependent)

    def _part(self, matrix: sp.csr_matrix, rows: IntArray) -> sp.csr_matrix:
        T = self.parts.T[:, rows]
        part = sp.csr_matrix(T.T @ matrix @ T)
        return sp.csr_matrix(0.5 * (part + part.T))


def _of_mesh(problem: ShellProblem) -> tuple[Array, Array, list[Any]]:
    """Reference direction (c, 3), sign of the normal (c,) and laminate of each cell of the mesh."""
    count = len(problem.mesh.cells)
    first, sign = np.empty((count, 3)), np.empty(count)
    laminates: list[Any] = [None] * count
    for region in problem.regions:
        given = problem.spec["regions"]
        table = given.get(region.name) or given["all"]
        first[region.cells] = cell_directions(problem.mesh, table, region.cells, problem.where)
        sign[region.cells] = -1.0 if table.get("flip", False) else 1.0
        for cell in region.cells:
            laminates[cell] = region.stiffness
    return first, sign, laminates
