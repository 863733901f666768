"""Matrices and vectors that DOLFINx assembles for shells and solids, in the order of a plain mesh.

Shells: surfaces of triangles and quadrilaterals with six unknowns a node. Cells of one kind are one
mesh of DOLFINx; the meshes of both kinds are assembled into one matrix of PETSc. Solids: forms in
UFL. Importing this module loads DOLFINx and UFL."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl

from ...solver.math.arrays import Array, IntArray
from .kernels import Kernel, matrix_form
from .libraries import MPI, PETSc, dolfinx
from .plain_mesh import PlainMesh, lagrange, quadrature
from .spaces import (
    assembled,
    cell_dofs,
    cell_function,
    compiled_form,
    dof_coordinates,
    dolfinx_mesh,
    nodes_of_cells,
    original_cells,
    quiet,
    vector_space,
)
from .team import ALONE, Team

DOFS = 6  # of a node: ux uy uz rx ry rz
AROUND = {3: [0, 1, 2], 4: [0, 1, 3, 2]}  # corners around a cell, from or to DOLFINx's order


class Surface:
    """Cells of one kind.

    Parameters
    ----------
    points : (n, 3) nodes [m]
    cells : (c, 3|4) rows of points, around each cell; no row twice in a cell
    """

    def __init__(self, points: Array, cells: IntArray) -> None:
        used, inverse = np.unique(cells, return_inverse=True)
        kind = "triangle" if cells.shape[1] == 3 else "quadrilateral"
        region = np.zeros(len(cells), dtype=np.int64)
        plain = PlainMesh(points[used], inverse.reshape(cells.shape), kind, 1, region, ("surface",))
        mesh = dolfinx_mesh(plain)
        space = vector_space(mesh, 1, DOFS)
        self.cells = cells
        self.order = original_cells(mesh)
        self._form, self._integral = matrix_form(space)
        dofs = cell_dofs(space)
        self._nodes = np.empty(len(used), dtype=np.int32)  # of the dofs of DOLFINx
        self._nodes[dofs] = used[nodes_of_cells(mesh)]
        self._space = space

    def add_to(self, matrix: "PETSc.Mat", kernel: Kernel, table: Array) -> None:
        """Add the matrices of the cells.

        Parameters
        ----------
        matrix : of PETSc, six rows per node of `points`
        kernel : lists of pairs of these cells
        table : (c, columns) data of the kernel, in the order of `cells`
        """
        if len(table) != len(self.order):
            raise ValueError(f"{len(table)} rows of data for {len(self.order)} cells")
        kernel.check(table.shape[1], self.cells.shape[1])
        numbering = PETSc.LGMap().create(self._nodes, bsize=DOFS, comm=MPI.COMM_SELF)
        matrix.setLGMap(numbering, numbering)
        key = (dolfinx.fem.IntegralType.cell, self._integral)
        data = {key: np.ascontiguousarray(table[self.order])}
        with quiet():
            dolfinx.cpp.fem.petsc.assemble_matrix(matrix, self._form, kernel.constants, data, [])
        numbering.destroy()


class SurfacePattern:
    """Where the matrix of some surfaces has blocks.

    Parameters
    ----------
    tables : tables of nodes of all cells and lines
    n_node : number of nodes; a node without cells has no entries
    """

    def __init__(self, tables: Sequence[IntArray], n_node: int) -> None:
        nodes = np.concatenate([table.ravel() for table in tables])
        sizes = np.concatenate([np.full(len(table), table.shape[1]) for table in tables])
        starts = np.concatenate([[0], np.cumsum(sizes)])
        ones = np.ones(len(nodes), dtype=np.int32)
        incidence = sp.csr_matrix((ones, nodes, starts), shape=(len(sizes), n_node))
        near = (incidence.T @ incidence).sorted_indices()
        blocks = np.ones((near.nnz, DOFS, DOFS), dtype=np.int8)
        entries = sp.bsr_matrix((blocks, near.indices, near.indptr)).tocsr()
        self.n_dof = DOFS * n_node
        self._starts, self._columns = (
            part.astype(PETSc.IntType) for part in (entries.indptr, entries.indices)
        )

    def summed(self, parts: Sequence[tuple[Surface, Kernel, Array]]) -> sp.csr_matrix:
        """Sum of the matrices of the cells of surfaces with their kernels and tables.

        All sums share the arrays of their pattern, and PETSc adds into those of the result.

        Paper: Eq. (24).
        """
        shape, values = (self.n_dof, self.n_dof), np.zeros(len(self._columns))
        pattern = self._starts, self._columns
        matrix = PETSc.Mat().createAIJWithArrays(shape, (*pattern, values), comm=MPI.COMM_SELF)
        try:
            matrix.setBlockSize(DOFS)  # older versions take none before
            for surface, kernel, table in parts:
                surface.add_to(matrix, kernel, table)
            matrix.assemble()
        finally:
            matrix.destroy()
        return sp.csr_matrix((values, self._columns, self._starts), shape=shape)


class SolidSpace:
    """Displacements on cells of degree 2, of which each process of a team has a share.

    Those of degree 2 have an unknown at every node of the mesh, in its order. Other degrees are for
    one process.

    Attributes
    ----------
    space : of DOLFINx, three components
    points : (n, 3) where the unknowns are [m]
    """

    def __init__(self, plain: PlainMesh, degree: int = 2, team: Team = ALONE) -> None:
        own = team.slice_of(plain.points[plain.cells].mean(axis=1))
        used, inverse = np.unique(plain.cells[own], return_inverse=True)
        cells, region = inverse.reshape(-1, plain.cells.shape[1]), plain.region[own]
        self._plain = replace(plain, points=plain.points[used], cells=cells, region=region)
        self._mesh, self._team = dolfinx_mesh(self._plain), team
        self.space = vector_space(self._mesh, degree, 3)
        self._cells = own[original_cells(self._mesh)]  # rows of the plain mesh
        self._here = np.full(len(plain.cells), -1)  # cells of DOLFINx; -1: of other processes
        self._here[self._cells] = np.arange(len(own))
        self._nodes = used[nodes_of_cells(self._mesh)]
        self.points = dof_coordinates(self.space)
        self._row = np.arange(len(self.points))
        if degree == 2:  # geometry and space share the element
            self.points = plain.points
            self._row[cell_dofs(self.space)] = self._nodes

    def of_cells(self, values: Array) -> Any:
        """A coefficient with a constant tensor in each cell of the plain mesh, (c, ...)."""
        return cell_function(self._mesh, np.asarray(values)[self._cells])

    def at_points(self, values: Callable[[Array, IntArray], Array], rule: int) -> Any:
        """A coefficient by its tensors at the points (c, q, 3) of integration of some cells (c,).

        `rule` is the degree of the integration, and has to be that of its form.
        """
        cell = self._plain.cell
        functions = lagrange(cell, 2, quadrature(cell, rule)[0])[0]
        points = functions @ self._plain.points[nodes_of_cells(self._mesh)]
        return cell_function(self._mesh, values(points, self._cells), rule)

    def _faces(
        self, owner: IntArray, corners: IntArray
    ) -> Iterator[tuple[int, IntArray, IntArray]]:
        """Yield each face of the cells of DOLFINx, its unknowns, and the cells that have it."""
        cell = self._here[owner]
        cell, corners = cell[cell >= 0], corners[cell >= 0]
        is_corner = (self._nodes[cell][:, :, None] == corners[:, None]).any(axis=2)
        vertices = 4 if self._plain.cell == "tetrahedron" else 8
        for face in range(4 if vertices == 4 else 6):
            closure = np.array(self.space.dofmap.dof_layout.entity_closure_dofs(2, face))
            yield face, closure, cell[is_corner[:, closure[closure < vertices]].all(axis=1)]

    def on_faces(self, owner: IntArray, corners: IntArray) -> IntArray:
        """Points on faces, given by cells (f,) and corners (f, 3 or 4) of the plain mesh."""
        dofs, faces = cell_dofs(self.space), self._faces(owner, corners)
        rows = [dofs[cells][:, closure].ravel() for _, closure, cells in faces]
        return np.unique(self._team.stacked(self._row[np.concatenate(rows)]))

    def over_faces(self, owner: IntArray, corners: IntArray) -> Any:
        """UFL's measure of integration over such faces."""
        self._mesh.topology.create_connectivity(3, 2)
        of_cell = self._mesh.topology.connectivity(3, 2)
        faces = self._faces(owner, corners)
        facets = [of_cell.links(c)[face] for face, _, cells in faces for c in cells]
        rows = np.sort(np.array(facets, dtype=np.int32))
        tags = dolfinx.mesh.meshtags(self._mesh, 2, rows, np.ones(len(rows), dtype=np.int32))
        return ufl.Measure("ds", self._mesh, subdomain_data=tags)(1)

    def field(self) -> Any:
        """A displacement field, to be filled by `fill`."""
        return dolfinx.fem.Function(self.space)

    def fill(self, field: Any, u: Array) -> None:
        """Give a field the displacements u (n, 3) of the nodes."""
        field.x.array[:] = u[self._row].ravel()

    def matrix(self, form: Any) -> Any:
        """A symmetric bilinear form, (3 n, 3 n), node by node, or the part of this process."""
        A, order, n = assembled(form), self._order, 3 * len(self.points)
        starts = np.zeros(n + 1, dtype=A.indptr.dtype)
        starts[1 + order] = np.diff(A.indptr)
        A = A[np.argsort(order)]
        A = sp.csr_matrix((A.data, order[A.indices], starts.cumsum()), shape=(n, n))
        A.sort_indices()
        A.data = 0.5 * (A.data + A.T.tocsr().data)  # the pattern is symmetric
        A.eliminate_zeros()  # two thirds of a mass matrix
        return self._team.part(A)

    def vectors(self, form: Any) -> Callable[[], Array]:
        """Assembles a linear form with the present values of its fields, (3 n,)."""
        compiled = compiled_form(form)

        def vector() -> Array:
            assembled = dolfinx.fem.petsc.assemble_vector(compiled)
            out = np.zeros(3 * len(self.points))
            out[self._order] = assembled.getArray()
            assembled.destroy()
            return self._team.total(out)

        return vector

    @property
    def _order(self) -> IntArray:
        return np.asarray((3 * self._row[:, None] + np.arange(3)).ravel())
