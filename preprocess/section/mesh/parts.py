"""Cells with the same functions: the parts from which a space is put together."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from ufl import JacobianDeterminant, SpatialCoordinate, as_vector

from ....solver.math.arrays import Array
from ... import fenicsx
from .cells import (
    CORNERS,
    FULL,
    KINDS,
    CellMesh,
    IntArray,
    filling,
    full_basis,
    order_of_nodes,
    patterns,
    within,
)
from .numbering import Numbering

EVERY = slice(None)


@dataclass(frozen=True)
class Part:
    """Some cells of one kind with the same functions; `c` counts them, `k` their nodes."""

    kind: int
    rows: IntArray  # (c,) of the mesh
    domain: Any  # DOLFINx mesh of the own cells of the kind
    own: IntArray  # (c,) rows of this mesh, -1 for other cells
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
        u = fenicsx.scalar_argument(self.domain, self.degree or 2)
        found = self.evaluated(as_vector([u, u.dx(0), u.dx(1)]), points, some)
        # A translation has no strain. The rounding of compiled tables is the same in all cells, so
        # that it would add up: very thin strips lose half a digit by it.
        found[:, :, 1:] -= found[:, :, :1] * found[:, :, 1:].sum(axis=-1, keepdims=True)
        if self.filling is None:
            return found
        return np.asarray(found[..., order_of_nodes(self.kind)] @ self.filling)

    def map(self, points: Array, some: IntArray) -> Array:
        """Positions x2, x3 and determinant of the map of some cells at points, (c, q, 3)."""
        x = SpatialCoordinate(self.domain)
        return self.evaluated(
            as_vector([x[0], x[1], JacobianDeterminant(self.domain)]), points, some
        )

    def values(self, points: Array) -> Array:
        """The functions at points of the reference cell, (q, k)."""
        if self.filling is not None:
            return np.asarray(full_basis(self.kind, points)[0] @ self.filling)
        assert self.degree is not None
        return fenicsx.lagrange(KINDS[self.kind], self.degree, points)[0]

    def evaluated(self, expression: Any, points: Array, some: IntArray | slice = EVERY) -> Array:
        """A UFL expression on `domain` at points of some reference cells, (c, q, ...)."""
        return fenicsx.evaluated(self.domain, expression, points, self.own[some])

    def places(self) -> Array:
        """Positions of the nodes of the functions, (c, k, 2) [m]."""
        if self.degree is None:
            assert self.filling is not None
            present = np.flatnonzero(self.filling.max(axis=1) == 1.0)
            return self.shape[:, present]
        reference = fenicsx.reference_nodes(KINDS[self.kind], self.degree)
        return np.asarray(full_basis(self.kind, reference)[0] @ self.shape)


def lagrange_parts(
    mesh: CellMesh, degree: int, some: slice
) -> tuple[list[Part], int, sp.csr_matrix | None]:
    """Lagrange functions: the parts, the number of nodes, and `Numbering.expansion`."""
    numbering = Numbering(mesh, degree)
    parts = [
        Part(kind, rows, domain, _numbers(rows, some), shape, nodes, degree, None)
        for (kind, rows), domain, shape, nodes in zip(
            mesh.of_kinds, mesh.domains(some), mesh.shapes, numbering.of_cells, strict=True
        )
    ]
    return parts, numbering.n_node, numbering.expansion()


def own_parts(mesh: CellMesh, some: slice) -> tuple[list[Part], int]:
    """The functions of the nodes that each cell has: the parts and the number of nodes."""
    used, compact = np.unique(mesh.nodes, return_inverse=True)
    absent = int(used[0] < 0)
    table = compact.reshape(mesh.nodes.shape) - absent
    parts = []
    for (kind, rows), domain, shape in zip(
        mesh.of_kinds, mesh.domains(some), mesh.shapes, strict=True
    ):
        numbers = _numbers(rows, some)
        nodes = table[rows, : FULL[kind]]
        for pattern, of in patterns(nodes):
            own = nodes[of][:, pattern]
            fill = filling(kind, pattern)
            parts.append(Part(kind, rows[of], domain, numbers[of], shape[of], own, None, fill))
    return parts, len(used) - absent


def _numbers(rows: IntArray, some: slice) -> IntArray:
    """Rows of the cells in the DOLFINx mesh of those in a slice; -1 for the others."""
    inside = within(rows, some)
    return np.where(inside, np.cumsum(inside) - 1, -1)
