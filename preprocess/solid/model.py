"""Matrices of a free solid, assembled by DOLFINx, as a body that any reduction takes."""

from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import Any

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ..exchange.direct import Solver
from ..exchange.free_body import Cells, FreeBody
from ..exchange.links import Constrained
from ..fenicsx.solids import SolidSpace
from .cells import VTK
from .forms import MASS_DEGREE, Elasticity, mass, pressure
from .materials import CellMaterials, cell_materials
from .mesh import SolidMesh, solid_mesh
from .places import interface_faces
from .solvers import Iterative, Mumps

MOST_FACTORISED = 400_000  # unknowns; the factors of more need tens of gigabytes


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

    def elasticity(self, space: SolidSpace, degree: int = 2) -> Elasticity:
        """Stresses of strains; material axes that change within cells are coefficients, too."""
        C, axes, cell = self.materials.C_M, None, self.mesh.plain.cell
        if self.materials.is_curved:
            axes = space.of_nodes(self.materials.axes)
        else:
            C = self.materials.C_B(self.mesh.plain)
        return Elasticity(space.of_cells(C), cell, axes, degree)

    @cached_property
    def body(self) -> FreeBody:
        """Stiffness and mass of the free body; its groups are the nodes of the interfaces."""
        plain = self.mesh.plain
        kind, order = VTK[plain.cell]
        cells = plain.cells[:, order]
        table = Cells(
            cells.ravel(), cells.shape[1] * np.arange(len(cells) + 1), np.full(len(cells), kind)
        )
        notes = {"cells": len(cells), "cell": plain.cell, "regions": list(plain.regions)}
        return self._body(self.space, table, notes)

    @property
    def counts(self) -> bool:
        """Its vibrations are counted, which needs factors."""
        return 3 * len(self.mesh.plain.points) <= MOST_FACTORISED

    @property
    def solver(self) -> Callable[[Constrained], Solver]:
        """Makes the solver of the reduced unknowns: by factors, or with less memory."""
        return Mumps if self.counts else partial(Iterative, self.mesh.plain)

    def unit_pressure(self, name: str) -> Array:
        """Nodal forces (3 n,) of a pressure of 1 Pa on the faces of an interface."""
        owner, corners = (rows[self.faces[name]] for rows in (self.mesh.owner, self.mesh.corners))
        over = self.space.over_faces(owner, corners)
        return self.space.vectors(pressure(self.space.space, over))()

    def richer(self) -> FreeBody:
        """The same mesh with displacements of degree 3: for errors of the frequencies."""
        empty = np.zeros(0, dtype=np.int64)
        none = Cells(empty, np.zeros(1, dtype=np.int64), empty)
        return self._body(SolidSpace(self.mesh.plain, 3), none, {}, 3)

    def _body(
        self, space: SolidSpace, cells: Cells, notes: dict[str, Any], degree: int = 2
    ) -> FreeBody:
        n, rho = len(space.points), space.of_cells(self.materials.rho)
        return FreeBody(
            where=self.where,
            nodes=space.points,
            node_ids=np.arange(1, n + 1),
            cells=cells,
            K=space.matrix(self.elasticity(space, degree).stiffness(space.space)),
            M=space.matrix(mass(space.space, rho, MASS_DEGREE + 2 * (degree - 2))),
            dof_node=np.repeat(np.arange(n), 3),
            dof_direction=np.tile(np.arange(3), n),
            groups={
                name: space.on_faces(self.mesh.owner[rows], self.mesh.corners[rows])
                for name, rows in self.faces.items()
            },
            notes=notes,
        )

    @property
    def links(self) -> dict[str, Any]:
        """Tables of the interfaces for the reduction (exchange/import_table.py)."""
        kept = ("link", "position", "rotation_deg")
        return {
            name: {"set": name, "weights": "area", **{k: v for k, v in t.items() if k in kept}}
            for name, t in self.interfaces.items()
        }
