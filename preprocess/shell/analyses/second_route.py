"""Laminated shells by a second formulation, which judges the elements: `plymotion shell --verify`.

Quadratic displacement and Crouzeix-Raviart rotations on flat triangles, as a UFL form assembled by
DOLFINx (the pair of Campello, Pimenta and Wriggers, Comput. Mech. 31 (2003) 505). It shares no
formula with the elements: no discrete shear constraint, no drilling dof in the membrane. Jumps of
the rotations have a stiffness (Hansbo and Larson, Math. Model. Numer. Anal. 37 (2003) 63). Of the
engine it takes the mesh, the stiffness of the laminates and their reference directions.
"""

from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from scipy.spatial import cKDTree

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import corner_counts
from ... import fenicsx
from ...fenicsx.spaces import (
    assembled,
    cell_function,
    dof_coordinates,
    function_space,
    labelled_mesh,
    original_cells,
    p2_cr_element,
    quiet,
)
from ..mesh.axes import cell_directions
from ..model.problem import ShellProblem
from .second_links import Parts, Spread

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
        self.sides, found = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
        self.of_cells = found.reshape(-1, 3)  # side opposite to each corner
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
        self.mesh = labelled_mesh(plain).mesh
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
        found = np.empty((len(places), 3), dtype=np.int64)
        for row in range(3):
            with quiet():
                space, numbers = self.space.sub(field).sub(row).collapse()
            nearest = cKDTree(dof_coordinates(space)).query(places)[1]
            found[:, row] = np.ravel(numbers)[nearest]
        return found

    def numbers(self, ends: IntArray) -> IntArray:
        """Rows of `sides` of pairs of nodes (k, 2)."""
        n = len(self.points)
        low, high = np.sort(ends, axis=1).T
        return np.searchsorted(self.sides @ np.array([n, 1]), low * n + high)

    def spread(self, names: Any) -> Spread:
        """Places and weights of physical groups, one name or several; None: all cells."""
        mesh, found = self.problem.mesh, []
        for name in names if isinstance(names, list | tuple) else [names]:
            if name in mesh.marks:
                nodes = mesh.marks[name]
                near = np.flatnonzero(np.isin(self.sides, nodes).any(axis=1))
                found.append(Spread(nodes, np.ones(len(nodes)), near, np.ones(len(near))))
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
            found.append(Spread(at, np.concatenate(weights), rows.ravel(), turned))
        return Spread(*(np.concatenate(part) for part in zip(*found, strict=True)))

    def solve(self, rhs: Array, fixed: Array, given: Array) -> Array:
        """All unknowns (k,) under a right-hand side, those that are `fixed` as `given`."""
        T, free = self.parts.T, self._free(fixed)
        found = np.where(self.parts.dependent, 0.0, given)
        load = T.T @ (rhs - self.K @ (T @ found))
        found[free] = fenicsx.cholesky(self._part(self.K, free)).solve(load[free])
        return np.asarray(T @ found)

    def eigenvalues(self, count: int, fixed: Array, target: float = 0.0) -> Array:
        """Lowest squared circular frequencies (count,) [rad2/s2], nearest to `target`."""
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
