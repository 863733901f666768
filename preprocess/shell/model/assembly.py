"""Matrices of a shell: DOLFINx assembles the pairs of its cells (pairs.py).

Six unknowns per node, in the node numbering of the mesh; reference points of links come after the
nodes. Of several processes, each assembles the matrix of its own cells: the sum of all is that of
the shell.
"""

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array, IntArray
from ... import fenicsx
from ..elements.choice import Choice
from ..elements.table import cell_table, write
from ..mesh.mesh import ShellMesh
from .regions import Region

DOFS = 6  # dofs of a node: ux uy uz rx ry rz


class Assembly:
    """The cells of a shell as surfaces of DOLFINx, one for each kind of cell.

    Parameters
    ----------
    regions : the cells that are assembled
    extra : number of nodes without cells after those of the mesh
    """

    def __init__(
        self,
        mesh: ShellMesh,
        regions: Sequence[Region],
        choice: Choice,
        extra: int,
    ) -> None:
        self._mesh, self._choice, self._extra = mesh, choice, extra
        kinds = [[r for r in regions if r.nodes.shape[1] == k] for k in (3, 4)]
        self._kinds = [kind for kind in kinds if kind]

    @cached_property
    def _surfaces(self) -> list[fenicsx.Surface]:
        points = self._mesh.points_G
        return [
            fenicsx.Surface(points, np.concatenate([region.nodes for region in kind]))
            for kind in self._kinds
        ]

    @cached_property
    def _pattern(self) -> fenicsx.SurfacePattern:
        return fenicsx.SurfacePattern(
            [surface.cells for surface in self._surfaces], self._mesh.n_node + self._extra
        )

    def matrix(self, kernel: Callable[[int], fenicsx.Kernel], **entries: Array) -> sp.csr_matrix:
        """Sum of the matrices of the cells, (n_dof, n_dof) with ascending columns.

        Parameters
        ----------
        kernel : of cells with a number of corners (pairs.py)
        entries : of the table of the cells by their names, in the order of the mesh
        """
        # first, because what DOLFINx needs a compiler for gives a worse message without one
        kernels = [kernel(kind[0].nodes.shape[1]) for kind in self._kinds]
        parts = []
        for surface, kind, found in zip(self._surfaces, self._kinds, kernels, strict=True):
            data = [cell_table(r.geometry, r.stiffness, self._choice) for r in kind]
            table = np.concatenate(data)
            cells = np.concatenate([region.cells for region in kind])
            write(table, **{name: values[cells] for name, values in entries.items()})
            parts.append((surface, found, table))
        return self._pattern.summed(parts)

    def lines(self, ends: IntArray, matrices: Array) -> sp.csr_matrix:
        """Sum of matrices (l, 12, 12) of lines with nodes (l, 2)."""
        dofs = (DOFS * ends[:, :, None] + np.arange(DOFS)).reshape(len(ends), -1)
        rows = np.repeat(dofs, dofs.shape[1], axis=1).ravel()
        columns = np.tile(dofs, dofs.shape[1]).ravel()
        n_dof = DOFS * (self._mesh.n_node + self._extra)
        return sp.csr_matrix((matrices.ravel(), (rows, columns)), shape=(n_dof, n_dof))
