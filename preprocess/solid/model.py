"""Matrices of a free solid, assembled by DOLFINx, as a body that any reduction takes."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from ...solver.math.arrays import Array, IntArray
from .. import fenicsx
from ..exchange.free_body import FreeBody
from ..exchange.layups import Cells
from ..fenicsx.solids import SolidSpace
from .cells import VTK
from .forms import mass, stiffness
from .materials import CellMaterials, cell_materials
from .mesh import SolidMesh, solid_mesh
from .places import interface_faces


class SolidModel:
    """A meshed solid with materials and interfaces.

    Parameters
    ----------
    solid : `SolidTable` of a specification
    interfaces : `SolidInterfaceTable` by name
    where : key of the description, for messages
    size : of the cells [m], in place of that of the description

    Raises SolidError.
    """

    def __init__(
        self,
        solid: Mapping[str, Any],
        interfaces: Mapping[str, Any],
        where: str,
        size: float | None = None,
    ) -> None:
        self.where = where
        self.mesh: SolidMesh = solid_mesh(solid["mesh"], f"{where}.mesh", size)
        self.materials: CellMaterials = cell_materials(
            self.mesh, solid["regions"], solid["materials"], where
        )
        self.interfaces = dict(interfaces)
        self.faces: dict[str, IntArray] = {
            name: interface_faces(self.mesh, table, f"{where}.interfaces.{name}")
            for name, table in interfaces.items()
        }

    @cached_property
    def space(self) -> SolidSpace:
        """Displacements of the nodes."""
        return SolidSpace(self.mesh.plain)

    @cached_property
    def body(self) -> FreeBody:
        """Stiffness and mass of the free body; its groups are the nodes of the interfaces."""
        plain, space = self.mesh.plain, self.space
        K = space.matrix(stiffness(space.space, space.of_cells(self.materials.C), plain.cell))
        M = space.matrix(mass(space.space, space.of_cells(self.materials.rho)))
        n = len(plain.points)
        kind, order = VTK[plain.cell]
        cells = plain.cells[:, order]
        return FreeBody(
            where=self.where,
            nodes=plain.points,
            node_ids=np.arange(1, n + 1),
            cells=Cells(
                cells.ravel(),
                cells.shape[1] * np.arange(len(cells) + 1),
                np.full(len(cells), kind),
            ),
            K=0.5 * (K + K.T),
            M=0.5 * (M + M.T),
            dof_node=np.repeat(np.arange(n), 3),
            dof_direction=np.tile(np.arange(3), n),
            groups={name: self.mesh.face_nodes(rows) for name, rows in self.faces.items()},
            notes={"cells": len(cells), "cell": plain.cell, "regions": list(plain.regions)},
        )

    @property
    def links(self) -> dict[str, Any]:
        """Tables of the interfaces for the reduction (exchange/spec.py)."""
        kept = ("link", "position", "rotation_deg")
        return {
            name: {"set": name, "weights": "area", **{k: v for k, v in t.items() if k in kept}}
            for name, t in self.interfaces.items()
        }


class Mumps:
    """Direct solver of a reduction by MUMPS and SLEPc, see exchange/direct.py."""

    def __init__(self, places: Array) -> None:
        del places  # MUMPS orders by the pattern of the matrix
        self._last: tuple[Any, Any] | None = None

    def add_subset(self, kept: IntArray) -> None:
        """Systems in fewer unknowns will come."""

    def solve(self, A: Any, B: Array) -> Array:
        """Solve A X = B; factors of the same A are used again."""
        if self._last is None or self._last[0] is not A:
            self._last = A, fenicsx.cholesky(A, solid=True)
        return np.asarray(self._last[1].solve(B))

    def negative_pivots(self, A: Any) -> int:
        """Number of negative eigenvalues of A. Raises ArithmeticError if A is singular."""
        try:
            return fenicsx.negative_pivots(A, solid=True)
        except fenicsx.InertiaError as error:
            raise ArithmeticError(str(error)) from error

    def eigenpairs(self, K: Any, M: Any, count: int) -> tuple[Array, Array]:
        """Lowest values (count,) and vectors of K x = value M x."""
        self._last = None
        return fenicsx.eigenpairs(K, M, count, solid=True)
