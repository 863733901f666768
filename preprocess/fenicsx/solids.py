"""Forms of solids, assembled by DOLFINx into matrices and vectors in the order of a plain mesh.

Importing this module loads DOLFINx and UFL.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from .plain import PlainMesh
from .spaces import (
    cell_dofs,
    cell_function,
    labelled_mesh,
    original_cells,
    quiet,
    vector_space,
)
from .stack import dolfinx


class SolidSpace:
    """Displacements of degree 2 on cells of degree 2: an unknown at every node of the mesh.

    Attributes
    ----------
    space : of DOLFINx, three components
    n_node : number of nodes
    """

    def __init__(self, plain: PlainMesh) -> None:
        self._mesh = labelled_mesh(plain).mesh
        self.space = vector_space(self._mesh, 2, 3)
        self.n_node = len(plain.points)
        self._cells = original_cells(self._mesh)
        self._row = self._rows()

    def _rows(self) -> IntArray:
        """Row of the mesh for each node of the space: geometry and space share the element."""
        geometry = self._mesh.geometry
        table = geometry.dofmap
        if hasattr(table, "offsets"):  # AdjacencyList: all cells are of one kind
            table = np.asarray(table.array).reshape(len(table.offsets) - 1, -1)
        given = np.asarray(geometry.input_global_indices, dtype=np.int64)
        rows = np.empty(self.n_node, dtype=np.int64)
        rows[cell_dofs(self.space).ravel()] = given[np.asarray(table).ravel()]
        return rows

    def of_cells(self, values: Array) -> Any:
        """A coefficient with a constant tensor in each cell of the plain mesh, (c, ...)."""
        return cell_function(self._mesh, np.asarray(values)[self._cells])

    def field(self) -> Any:
        """A displacement field, to be filled by `fill`."""
        return dolfinx.fem.Function(self.space)

    def fill(self, field: Any, u: Array) -> None:
        """Give a field the displacements u (n, 3) of the nodes."""
        field.x.array[:] = u[self._row].ravel()

    def matrix(self, form: Any) -> sp.csr_matrix:
        """A bilinear form, (3 n, 3 n), node by node."""
        with quiet():
            compiled = dolfinx.fem.form(form)
        found = dolfinx.fem.petsc.assemble_matrix(compiled)
        found.assemble()
        indptr, indices, data = found.getValuesCSR()
        shape = found.getSize()
        found.destroy()
        A = sp.csr_matrix((data, indices, indptr), shape=shape).tocoo()
        order = (3 * self._row[:, None] + np.arange(3)).ravel()
        return sp.csr_matrix((A.data, (order[A.row], order[A.col])), shape=shape)

    def vectors(self, form: Any) -> Callable[[], Array]:
        """Assembles a linear form with the present values of its fields, (3 n,)."""
        with quiet():
            compiled = dolfinx.fem.form(form)
        order = (3 * self._row[:, None] + np.arange(3)).ravel()

        def vector() -> Array:
            found = dolfinx.fem.petsc.assemble_vector(compiled)
            out = np.empty(3 * self.n_node)
            out[order] = found.getArray()
            found.destroy()
            return out

        return vector
