"""Surfaces of triangles and quadrilaterals with six unknowns a node, assembled by DOLFINx.

Cells of one kind are one mesh of DOLFINx; the meshes of both kinds are assembled into one matrix of
PETSc in the numbering of the nodes that the caller has.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from .kernels import Kernel, matrix_form
from .plain import PlainMesh
from .spaces import cell_dofs, labelled_mesh, nodes_of_cells, original_cells, quiet, vector_space
from .stack import MPI, PETSc, dolfinx

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
        mesh = labelled_mesh(plain).mesh
        space = vector_space(mesh, 1, DOFS)
        self.cells = cells
        self.order = original_cells(mesh)
        self._form, self._integral = matrix_form(space)
        dofs = cell_dofs(space)
        self._nodes = np.empty(len(used), dtype=np.int32)  # of the dofs of DOLFINx
        self._nodes[dofs] = used[nodes_of_cells(mesh)]
        self._space = space

    def add_to(self, matrix: "PETSc.Mat", kernel: Kernel, table: Array) -> None:
        """Add the matrices of the cells, with data (c, columns) in the order of `cells`."""
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
