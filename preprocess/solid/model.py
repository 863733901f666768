"""Matrices of a free solid, assembled by DOLFINx, as a body that any reduction takes; its solvers.

Systems are solved by factors of MUMPS, or by conjugate gradients with two grids."""

from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import Any, cast

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from .. import fenicsx
from ..exchange.direct import Solver
from ..exchange.free_body import Cells, FreeBody
from ..exchange.import_table import InterfaceTable
from ..exchange.imported_interfaces import Constrained
from ..fenicsx import PlainMesh
from ..fenicsx.assembly import SolidSpace
from ..fenicsx.team import ALONE, Team
from ..parts import own
from .forms import MASS_DEGREE, Elasticity, mass, pressure, stiffness_rule
from .materials import CellMaterials, cell_materials
from .places import interface_faces
from .solid_mesh import CORNERS, VTK, SolidMesh, linear_weights, solid_mesh


class Mumps:
    """Direct solver of a reduction by MUMPS and SLEPc, see exchange/direct.py."""

    counts = True

    def __init__(self, parts: Constrained, team: Team = ALONE) -> None:
        del parts  # MUMPS orders by the pattern of the matrix
        self._team = team
        self._last: tuple[Any, Any] | None = None

    def add_subset(self, kept: IntArray) -> None:
        """Systems in fewer unknowns will come."""

    def solve(self, A: Any, B: Array) -> Array:
        """Solve A X = B; factors of the same A are used again."""
        if self._last is None or self._last[0] is not A:
            self._forget()
            self._last = A, fenicsx.cholesky(own(A), self._team, solid=True)
        return np.asarray(self._last[1].solve(B))

    def _forget(self) -> None:
        if self._last is not None:
            self._last[1].close()
        self._last = None

    def negative_pivots(self, A: Any) -> int:
        """Number of negative eigenvalues of A. Raises ArithmeticError if A is singular."""
        try:
            return fenicsx.negative_pivots(own(A), self._team, solid=True)
        except fenicsx.InertiaError as error:
            raise ArithmeticError(str(error)) from error

    def eigenpairs(self, K: Any, M: Any, count: int) -> tuple[Array, Array]:
        """Lowest values (count,) and vectors of K x = value M x.

        Parameters
        ----------
        K, M : (n, n) sparse, symmetric; the same on every process
        count : of the lowest values
        """
        self._forget()
        return fenicsx.eigenpairs(own(K), own(M), count, team=self._team, solid=True)


class Iterative:
    """Solver with the memory of the matrices: the coarse unknowns are those of the corners.

    It cannot count eigenvalues, which needs factors.
    """

    counts = False

    def __init__(self, plain: PlainMesh, parts: Constrained, team: Team = ALONE) -> None:
        P, self._team = _coarse(plain, parts), team
        self._P = {P.shape[0]: P}
        self._last: tuple[Any, Any] | None = None

    def add_subset(self, kept: IntArray) -> None:
        """Systems in fewer unknowns will come."""
        (P,) = self._P.values()
        some = sp.csc_matrix(P[kept])
        self._P[len(kept)] = some[:, np.diff(some.indptr) > 0]

    def solve(self, A: Any, B: Array) -> Array:
        """Solve A X = B; what is prepared for the same A is used again."""
        return np.asarray(self._grids(A).solve(B))

    def negative_pivots(self, A: Any) -> int:
        """Not possible without factors."""
        raise ArithmeticError(f"{A.shape[0]} unknowns are not factorised")

    def eigenpairs(self, K: Any, M: Any, count: int) -> tuple[Array, Array]:
        """Lowest values (count,) and vectors of K x = value M x.

        Parameters
        ----------
        K, M : (n, n) sparse, symmetric; the same on every process
        count : of the lowest values
        """
        return self._grids(K).eigenpairs(M, count)

    def _grids(self, A: Any) -> Any:
        if self._last is None or self._last[0] is not A:
            if self._last is not None:
                self._last[1].close()
            self._last = A, fenicsx.TwoGrids(A, self._P[A.shape[0]], self._team)
        return self._last[1]


def from_corners(plain: PlainMesh) -> sp.csr_matrix:
    """Weights (n, n) of all nodes in functions that are linear in each cell; its columns are those
    of corners."""
    n, W = len(plain.points), linear_weights(plain.cell)  # W: (nodes, corners)
    node, corner = np.nonzero(W)
    pairs = plain.cells[:, node] * n + plain.cells[:, corner]
    places, first = np.unique(pairs, return_index=True)
    values = np.tile(W[node, corner], len(plain.cells))[first]
    return sp.csr_matrix((values, np.divmod(places, n)), (n, n))


def _coarse(plain: PlainMesh, parts: Constrained) -> sp.csr_matrix:
    """Independent unknowns from those at corners and of rigid interfaces, linear in each cell."""
    nodal, vertices = from_corners(plain), CORNERS[plain.cell]
    T = sp.csc_matrix(parts.T)
    loose = T.shape[1] - 6 * len(parts.reference_dofs)
    dof = T.indices[T.indptr[:loose]]  # the only entry of its column
    coarse = np.isin(dof // 3, plain.cells[:, :vertices])
    columns = np.concatenate([np.flatnonzero(coarse), np.arange(loose, T.shape[1])])
    full = sp.kron(nodal, sp.eye(3), format="csr")[dof] @ T[:, columns]
    references = sp.eye(T.shape[1], format="csr")[loose:][:, columns]
    return sp.csr_matrix(sp.vstack([full, references]))


MOST_FACTORISED = 400_000  # unknowns; the factors of more need tens of gigabytes


class SolidModel:
    """A meshed solid with materials and interfaces.

    Parameters
    ----------
    solid : `SolidTable` of a specification
    interfaces : `SolidInterfaceTable` by name
    where : key of the body in a case, for messages; "" if the description has its interfaces
    size : of the cells [m], in place of that of the description
    team : processes that all make the same model: the first makes the mesh, each has the matrices
        of its own cells

    Raises SolidError.
    """

    def __init__(
        self,
        solid: Mapping[str, Any],
        interfaces: Mapping[str, Any],
        where: str = "",
        size: float | None = None,
        team: Team = ALONE,
    ) -> None:
        self.where, self.described = where, f"{where}.solid: " if where else ""
        self.mesh: SolidMesh = team.first(
            lambda: solid_mesh(solid["mesh"], f"{self.described}mesh", size)
        )
        self.team = team if len(self.mesh.plain.cells) >= team.size else ALONE
        self.materials: CellMaterials = cell_materials(
            self.mesh, solid["regions"], solid["materials"], self.described
        )
        self.interfaces = dict(interfaces)
        self.faces: dict[str, IntArray] = {
            name: interface_faces(self.mesh, table, f"{where}.interfaces.{name}".lstrip("."))
            for name, table in interfaces.items()
        }

    @cached_property
    def space(self) -> SolidSpace:
        """Displacements of the nodes."""
        return SolidSpace(self.mesh.plain, team=self.team)

    def elasticity(self, space: SolidSpace, degree: int = 2) -> Elasticity:
        """Stresses of strains; where material axes change within cells, C is that of each point."""
        plain, C_B = self.mesh.plain, self.materials.C_B
        rule = stiffness_rule(plain.cell, degree)
        if self.materials.is_curved:
            return Elasticity(space.at_points(C_B, rule), rule)
        centres = plain.points[plain.cells].mean(axis=1)
        return Elasticity(space.of_cells(C_B(centres, np.arange(len(centres)))), rule)

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
        kind = Mumps if self.counts else partial(Iterative, self.mesh.plain)
        return partial(kind, team=self.team)

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
        self, space: SolidSpace, cells: Cells, notes: dict[str, object], degree: int = 2
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
    def links(self) -> dict[str, InterfaceTable]:
        """Tables of the interfaces for the reduction (exchange/import_table.py)."""
        kept = ("link", "position", "rotation_deg")
        links = {
            name: {"set": name, "weights": "area", **{k: v for k, v in t.items() if k in kept}}
            for name, t in self.interfaces.items()
        }
        return cast(dict[str, InterfaceTable], links)
