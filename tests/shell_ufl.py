"""Laminated shells by a second formulation, to check the elements of preprocess/shell.

Quadratic displacement and Crouzeix-Raviart rotations on the same flat triangles, as a UFL form
assembled by DOLFINx (the pair of Campello, Pimenta and Wriggers, Comput. Mech. 31 (2003) 505). It
shares no formula with the elements: no discrete shear constraint, no drilling dof in the membrane.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx_forms import assembled, compile_forms
from numpy.typing import NDArray

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.spaces import (
    basix_ufl,
    cell_function,
    cell_name,
    dof_coordinates,
    function_space,
    labelled_mesh,
    original_cells,
    quiet,
)
from plymotion.preprocess.fenicsx.stack import dolfinx

Array = NDArray[np.float64]
DRILLING = 1.0  # stiffness of the turn about the normal against that of the surface, over A66


class UflShell:
    """Stiffness and mass of a laminated shell; unknowns are split by field and component.

    Parameters
    ----------
    plain : a `fenicsx.PlainMesh` of three-node triangles in space
    stiffness : of each region, with A, B, D (3, 3), Ds (2, 2) and mass (3,)
    direction_G : region -> (3,), projected on each triangle gives the first laminate axis
    """

    def __init__(self, plain: Any, stiffness: Any, direction_G: Any) -> None:
        self.plain, self.labelled = plain, labelled_mesh(plain)
        mesh = self.labelled.mesh
        corners = plain.points[plain.cells[original_cells(mesh)]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        regions = [plain.regions[label - 1] for label in self.labelled.cell_labels]
        first = np.array([direction_G[region] for region in regions], dtype=float)
        first -= normal * np.einsum("ci,ci->c", first, normal)[:, None]
        first /= np.linalg.norm(first, axis=1)[:, None]

        def of_cells(values: Any) -> Any:
            return cell_function(mesh, values)

        def laminate(name: str) -> Any:
            return of_cells([getattr(stiffness[region], name) for region in regions])

        # rows e1, e2, e3 of one tensor: the old UFL has no piecewise constant vectors in space
        A_EG = of_cells(np.stack([first, np.cross(normal, first), normal], axis=1))
        self.axes = [ufl.as_vector([A_EG[i, j] for j in range(3)]) for i in range(3)]
        self.space = _space(mesh)
        (u, theta), (du, dtheta) = (
            ufl.split(make(self.space)) for make in (ufl.TrialFunction, ufl.TestFunction)
        )
        A, B, D, Ds = (laminate(name) for name in ("A", "B", "D", "Ds"))
        e, k, g, d = self._strains(u, theta)
        de, dk, dg, dd = self._strains(du, dtheta)
        dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 2})
        energy = ufl.inner(A * e + B * k, de) + ufl.inner(B * e + D * k, dk)
        energy += ufl.inner(Ds * g, dg) + DRILLING * A[2, 2] * d * dd
        mass = [of_cells([stiffness[region].mass[n] for region in regions]) for n in range(3)]
        dx_mass = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 4})
        beta, dbeta = (ufl.cross(t, self.axes[2]) for t in (theta, dtheta))
        inertia = mass[0] * ufl.inner(u, du) + mass[2] * ufl.inner(theta, dtheta)
        inertia += mass[1] * (ufl.inner(u, dbeta) + ufl.inner(beta, du))
        self.K, self.M = assembled([energy * dx, inertia * dx_mass])
        self.fixed = np.zeros(self.K.shape[0], dtype=bool)
        self._parts = {
            name: self._component(field, row)
            for field, names in enumerate((("ux", "uy", "uz"), ("rx", "ry", "rz")))
            for row, name in enumerate(names)
        }
        self._dx, self._du = dx_mass, ufl.split(ufl.TestFunction(self.space))[0]

    def _strains(self, u: Any, theta: Any) -> tuple[Any, Any, Any, Any]:
        """Membrane strain, curvature (with doubled shear), transverse shear, drilling."""
        e1, e2, e3 = self.axes
        beta = ufl.cross(theta, e3)

        def derivative(field: Any, i: Any, j: Any) -> Any:
            return ufl.dot(i, ufl.dot(ufl.grad(field), j))

        def in_plane(field: Any) -> Any:
            return ufl.as_vector(
                [
                    derivative(field, e1, e1),
                    derivative(field, e2, e2),
                    derivative(field, e1, e2) + derivative(field, e2, e1),
                ]
            )

        # e3 is constant in a cell, so the gradient of theta x e3 is that of theta
        turning = ufl.as_tensor(
            [[ufl.cross(theta.dx(j), e3)[i] for j in range(3)] for i in range(3)]
        )
        pair = ((e1, e1), (e2, e2))
        curvature = [ufl.dot(i, ufl.dot(turning, j)) for i, j in pair]
        twist = ufl.dot(e1, ufl.dot(turning, e2)) + ufl.dot(e2, ufl.dot(turning, e1))
        shear = [ufl.dot(beta, e) + derivative(u, e3, e) for e in (e1, e2)]
        drill = ufl.dot(theta, e3) - 0.5 * (derivative(u, e2, e1) - derivative(u, e1, e2))
        return in_plane(u), ufl.as_vector([*curvature, twist]), ufl.as_vector(shear), drill

    def _component(self, field: int, row: int) -> tuple[Array, NDArray[np.int64]]:
        """Places (n, 3) [m] and numbers (n,) of the unknowns of one component."""
        with quiet():
            space, numbers = self.space.sub(field).sub(row).collapse()
        return dof_coordinates(space), np.ravel(numbers).astype(np.int64)

    def fix(self, names: str, where: Callable[[Array], Any]) -> None:
        """Hold components such as "ux rz" at the nodes whose places (n, 3) `where` says."""
        for name in names.split():
            places, numbers = self._parts[name]
            self.fixed[numbers[where(places)]] = True

    def at(self, name: str, place: Any) -> int:
        """Unknown of a component at a place."""
        places, numbers = self._parts[name]
        distance = np.linalg.norm(places - np.asarray(place, dtype=float), axis=1)
        row = int(np.argmin(distance))
        if distance[row] > 1e-6 * float(np.ptp(places, axis=0).max()):
            raise ValueError(f"no unknown {name} at {place}")
        return int(numbers[row])

    def pressure(self, load: Callable[[Any], Any]) -> Array:
        """Right-hand side of a force per area, a UFL vector of the place."""
        place = ufl.SpatialCoordinate(self.labelled.mesh)
        (form,) = compile_forms([ufl.inner(load(place), self._du) * self._dx])
        vector = dolfinx.fem.petsc.assemble_vector(form)
        return np.array(vector.array)

    def edge_force(self, ends: Array, force: Any) -> Array:
        """Right-hand side of a total force spread evenly over straight edges (s, 2, 3)."""
        rhs = np.zeros(self.K.shape[0])
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        for (a, b), share in zip(ends, length / length.sum(), strict=True):
            for place, weight in ((a, 1 / 6), (0.5 * (a + b), 4 / 6), (b, 1 / 6)):
                for name, value in zip(("ux", "uy", "uz"), force, strict=True):
                    rhs[self.at(name, place)] += share * weight * value
        return rhs

    def solve(self, rhs: Array) -> Array:
        """Displacements of all unknowns under a right-hand side."""
        free = np.flatnonzero(~self.fixed)
        found = np.zeros(self.K.shape[0])
        found[free] = fenicsx.cholesky(_part(self.K, free)).solve(rhs[free])
        return found

    def frequencies(self, count: int) -> Array:
        """Lowest natural frequencies [Hz]."""
        free = np.flatnonzero(~self.fixed)
        values, _ = fenicsx.eigenpairs(_part(self.K, free), _part(self.M, free), count)
        return np.asarray(np.sqrt(values) / (2.0 * np.pi))


def _part(matrix: sp.csr_matrix, rows: NDArray[np.int64]) -> sp.csr_matrix:
    part = sp.csr_matrix(matrix[rows][:, rows])
    return sp.csr_matrix(0.5 * (part + part.T))


def _space(mesh: Any) -> Any:
    if basix_ufl is not None:
        name = cell_name(mesh)
        parts = [
            basix_ufl.element("Lagrange", name, 2, shape=(3,)),
            basix_ufl.element("CR", name, 1, shape=(3,)),
        ]
        element = basix_ufl.mixed_element(parts)
    else:
        cell = mesh.ufl_cell()
        element = ufl.MixedElement(
            ufl.VectorElement("Lagrange", cell, 2, dim=3), ufl.VectorElement("CR", cell, 1, dim=3)
        )
    return function_space(mesh, element)
