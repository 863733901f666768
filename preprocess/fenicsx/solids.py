"""Forms of solids, assembled by DOLFINx into matrices and vectors in the order of a plain mesh.

Importing this module loads DOLFINx and UFL.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array
from .plain import PlainMesh
from .spaces import (
    assembled,
    cell_dofs,
    cell_function,
    compiled_form,
    labelled_mesh,
    nodes_of_cells,
    original_cells,
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
        # row of the mesh for each node of the space: geometry and space share the element
        self._row = np.empty(self.n_node, dtype=np.int64)
        self._row[cell_dofs(self.space)] = nodes_of_cells(self._mesh)

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
        A = assembled(form).tocoo()
        order = (3 * self._row[:, None] + np.arange(3)).ravel()
        return sp.csr_matrix((A.data, (order[A.row], order[A.col])), shape=A.shape)

    def vectors(self, form: Any) -> Callable[[], Array]:
        """Assembles a linear form with the present values of its fields, (3 n,)."""
        compiled = compiled_form(form)
        order = (3 * self._row[:, None] + np.arange(3)).ravel()

        def vector() -> Array:
            found = dolfinx.fem.petsc.assemble_vector(compiled)
            out = np.empty(3 * self.n_node)
            out[order] = found.getArray()
            found.destroy()
            return out

        return vector
