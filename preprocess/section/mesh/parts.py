"""Cells with the same functions: the parts from which a space is put together."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from ufl import JacobianDeterminant, SpatialCoordinate, as_vector

from ....solver.math.arrays import Array
from ... import fenicsx
from .cells import CORNERS, FULL, KINDS, CellMesh, IntArray, filling, full_basis, patterns
from .numbering import Numbering

EVERY = slice(None)


def with_slopes(_domain: Any, u: Any, _k: Any) -> Any:
    """u, u,2 and u,3 of the functions u of a cell."""
    return as_vector([u, u.dx(0), u.dx(1)])


def position(domain: Any, _u: Any, _k: Any) -> Any:
    """x2, x3 and the determinant of the map."""
    x = SpatialCoordinate(domain)
    return as_vector([x[0], x[1], JacobianDeterminant(domain)])


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

    def functions(self, points: Array, some: IntArray) -> Array:
        """The functions u with u,2 and u,3 of some cells at points of the reference cell,
        (c, q, 3, k)."""
        found = self.evaluated(with_slopes, points, some)
        # A translation has no strain. The rounding of compiled tables is the same in all cells, so
        # that it would add up: very thin strips lose half a digit by it.
        found[:, :, 1:] -= found[:, :, :1] * found[:, :, 1:].sum(axis=-1, keepdims=True)
        if self.filling is None:
            return found
        return np.asarray(found[..., fenicsx.order_of_nodes(KINDS[self.kind])] @ self.filling)

    def map(self, points: Array, some: IntArray) -> Array:
        """Positions x2, x3 and determinant of the map of some cells at points, (c, q, 3)."""
        return self.evaluated(position, points, some)

    def values(self, points: Array) -> Array:
        """The functions at points of the reference cell, (q, k)."""
        if self.filling is not None:
            return np.asarray(full_basis(self.kind, points)[0] @ self.filling)
        assert self.degree is not None
        return fenicsx.lagrange(KINDS[self.kind], self.degree, points)[0]

    def evaluated(
        self, text: Any, points: Array, some: IntArray | slice = EVERY, k: Array | None = None
    ) -> Array:
        """`fenicsx.evaluated` for some of the cells, with constants k."""
        return fenicsx.evaluated(
            text, KINDS[self.kind], self.degree or 2, points, self.shape[some], k
        )

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
        for pattern, of in patterns(nodes):
            fill = filling(kind, pattern)
            parts.append(Part(kind, rows[of], shape[of], nodes[of][:, pattern], None, fill))
    return parts, len(used) - absent
