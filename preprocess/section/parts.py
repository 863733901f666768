"""Cells with the same functions: the parts from which a space is put together."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array
from .. import fenicsx
from .cells import CORNERS, FULL, KINDS, CellMesh, IntArray, filling, full_basis, patterns
from .lagrange import basis
from .numbering import Numbering


@dataclass(frozen=True)
class Part:
    """Some cells of one kind with the same functions; `c` counts them, `k` their nodes."""

    kind: int
    rows: IntArray  # (c,) of the mesh
    shape: Array  # (c, 6 or 9, 2) positions of the nodes of the map [m]
    nodes: IntArray  # (c, k) nodes of the functions
    degree: int | None  # of Lagrange functions, None: those of `filling`
    filling: Array | None  # (6 or 9, k)

    @property
    def is_linear(self) -> bool:
        """True if the functions are those of corners only."""
        return self.nodes.shape[1] == CORNERS[self.kind]

    def functions(self, points: Array) -> tuple[Array, Array]:
        """Values (q, k) and slopes (q, k, 2) at points of the reference cell."""
        if self.degree is not None:
            return basis(KINDS[self.kind], self.degree, points)
        assert self.filling is not None
        values, slopes = full_basis(self.kind, points)
        return values @ self.filling, np.einsum("qig,ik->qkg", slopes, self.filling)

    def places(self) -> Array:
        """Positions of the nodes of the functions, (c, k, 2) [m]."""
        if self.degree is None:
            assert self.filling is not None
            present = np.flatnonzero(self.filling.max(axis=1) == 1.0)
            return self.shape[:, present]
        reference = fenicsx.reference_nodes(KINDS[self.kind], self.degree)
        return np.asarray(full_basis(self.kind, reference)[0] @ self.shape)


def lagrange_parts(mesh: CellMesh, degree: int) -> tuple[list[Part], int, sp.csr_matrix | None]:
    """Lagrange functions: the parts, the number of nodes, and `Numbering.expansion`."""
    numbering = Numbering(mesh, degree)
    parts = [
        Part(kind, rows, shape, nodes, degree, None)
        for (kind, rows), shape, nodes in zip(
            mesh.of_kinds, mesh.shapes, numbering.of_cells, strict=True
        )
    ]
    return parts, numbering.n_node, numbering.expansion()


def own_parts(mesh: CellMesh) -> tuple[list[Part], int]:
    """The functions of the nodes that each cell has: the parts and the number of nodes."""
    used, compact = np.unique(mesh.nodes, return_inverse=True)
    absent = int(used[0] < 0)
    table = compact.reshape(mesh.nodes.shape) - absent
    parts = []
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        nodes = table[rows, : FULL[kind]]
        for pattern, members in patterns(nodes):
            fill = filling(kind, pattern)
            parts.append(
                Part(kind, rows[members], shape[members], nodes[members][:, pattern], None, fill)
            )
    return parts, len(used) - absent
