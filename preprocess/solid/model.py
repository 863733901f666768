"""Matrices of a free solid, assembled by DOLFINx, as a body that any reduction takes; its solvers.

Systems are solved by factors of MUMPS, or by conjugate gradients with two grids."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, cast

import numpy as np
import scipy.sparse as sp

from ...solver.errors import few, nearest
from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.materials import material_from_dict, rotated
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
from .places import interface_faces, unit
from .solid_mesh import CORNERS, VTK, SolidError, SolidMesh, linear_weights, solid_mesh

# Stiffness and density of the cells of a solid, and the axes of its materials.

ALL = "all"
AT_ONCE = 200_000  # points whose nearest piece is sought at a time
SAME = 1e-9  # distance of two ends that are one, relative to the size of the curve
SPREAD = 1e7  # of stiffnesses of strains: with nu = 0.4999998 frequencies lose digits to 3e-5
NEAR = 1e-6  # part of a vector normal to another, relative to it
Axes = Callable[[Array], Array]  # of points (..., 3), (..., 3, 3): columns 1, 2, 3


class Curve:
    """Pieces (s, 2, 3) of a curve [m]; the tangent at a common end is the mean of both pieces."""

    def __init__(self, pieces: Array) -> None:
        self._start, self._along = pieces[:, 0], pieces[:, 1] - pieces[:, 0]
        self._square = (self._along**2).sum(axis=1)
        size = float(np.ptp(pieces.reshape(-1, 3), axis=0).max())
        ends = np.round(pieces.reshape(-1, 3) / (SAME * size))
        _, first, row = np.unique(ends, axis=0, return_index=True, return_inverse=True)
        row, each = row.ravel(), np.repeat(self._along, 2, axis=0)
        # curves of a mesh may run towards each other: as axes, both directions are the same
        tangents = np.zeros((len(first), 3))
        np.add.at(tangents, row, each * _sign(each, each[first][row]))
        tangents = tangents[row] * _sign(tangents[row], each)
        tangents /= np.linalg.norm(tangents, axis=1)[:, None]
        self._ends = tangents.reshape(-1, 2, 3)

    @classmethod
    def of(cls, table: Mapping[str, Any], curves: Mapping[str, Array], where: str) -> "Curve":
        """A curve by points, or of the mesh.

        Parameters
        ----------
        table : `points`, or `at`, the name of one of `curves`
        curves : pieces (s, 2, 3) by name [m]
        where : key of the table, for messages

        Raises
        ------
        SolidError
            No such curve; points that are not different.
        """
        if "at" in table:
            if table["at"] not in curves:
                raise SolidError(
                    f'{where}.at = "{table["at"]}": the mesh has no physical curve of this name'
                    f"{nearest(table['at'], curves)}; CAD files have none: expected points"
                )
            pieces = curves[table["at"]]
        else:
            points = np.array(table["points"], dtype=float)
            pieces = np.stack([points[:-1], points[1:]], axis=1)
        if not len(pieces) or not (np.ptp(pieces, axis=1).max(axis=1) > 0.0).all():
            raise SolidError(f"{where}: expected two or more different points, one after the other")
        return cls(pieces)

    def tangents(self, x: Array) -> Array:
        """Unit tangents at the points of the curve nearest to x (..., 3)."""
        flat = x.reshape(-1, 3)
        parts = [self._tangents(flat[i : i + AT_ONCE]) for i in range(0, len(flat), AT_ONCE)]
        return np.concatenate([np.zeros((0, 3)), *parts]).reshape(x.shape)

    def _tangents(self, x: Array) -> Array:
        best, piece, at = np.full(len(x), np.inf), np.zeros(len(x), dtype=int), np.zeros(len(x))
        for k, (start, along) in enumerate(zip(self._start, self._along, strict=True)):
            share = np.clip((x - start) @ along / self._square[k], 0.0, 1.0)
            distance = ((x - start - share[:, None] * along) ** 2).sum(axis=1)
            nearer = distance < best
            best[nearer], piece[nearer], at[nearer] = distance[nearer], k, share[nearer]
        one, other = self._ends[piece, 0], self._ends[piece, 1]
        tangent = (1.0 - at)[:, None] * one + at[:, None] * other
        return np.asarray(tangent / np.linalg.norm(tangent, axis=1, keepdims=True))


@dataclass(frozen=True)
class CellMaterials:
    """Elasticity of c cells.

    Attributes
    ----------
    C_M : (c, 6, 6) in the axes of the material [Pa]
    rho : (c,) [kg/m3]
    names : material of each region
    region : (c,) of each cell
    axes_of : axes of the orthotropic material of a region by its number
    is_curved : the axes of a region change within its cells
    """

    C_M: Array
    rho: Array
    names: tuple[str, ...]
    region: IntArray
    axes_of: dict[int, Axes]
    is_curved: bool

    def axes(self, points: Array, cells: IntArray) -> Array:
        """Axes A_BM (..., 3, 3) of the material at points (c, ..., 3) in some cells (c,)."""
        out = np.tile(np.eye(3), (*points.shape[:-1], 1, 1))
        for number, axes in self.axes_of.items():
            own = self.region[cells] == number
            out[own] = axes(points[own])
        return out

    def C_B(self, points: Array, cells: IntArray) -> Array:
        """Stiffness (..., 6, 6) in body axes at points (c, ..., 3) in some cells (c,) [Pa]."""
        C = self.C_M[cells].reshape(len(cells), *(1,) * (points.ndim - 2), 6, 6)
        return rotated(C, self.axes(points, cells)) if self.axes_of else C


def cell_materials(
    mesh: SolidMesh, regions: Mapping[str, Any], materials: Mapping[str, Any], where: str
) -> CellMaterials:
    """Materials of all cells.

    Parameters
    ----------
    mesh : of the solid
    regions : tables by the name of a volume, or of "all" others
    materials : tables by name
    where : prefix of keys in messages

    Raises
    ------
    SolidError
        Volumes without a region, regions without a volume, parallel axes.
    """
    plain = mesh.plain
    unknown = [name for name in regions if name not in (*plain.regions, ALL)]
    if unknown:
        hint = nearest(unknown[0], plain.regions)
        raise SolidError(f"{where}regions.{unknown[0]}: the solid has no such volume{hint}")
    C, rho, names = np.empty((len(plain.cells), 6, 6)), np.empty(len(plain.cells)), []
    axes: dict[int, Axes] = {}
    is_curved = False
    for number, name in enumerate(plain.regions):
        region = regions.get(name, regions.get(ALL))
        if region is None:
            raise SolidError(
                f"{where}regions.{name}: missing; the volumes are {few(plain.regions)}; expected "
                "a table for each, or for all"
            )
        key = f"{where}regions.{name if name in regions else ALL}"
        table = materials[region["material"]]
        of_material = f"{where}materials.{region['material']}"
        material = material_from_dict(table, of_material)
        spread = float(np.linalg.cond(material.stiffness_M))
        if not spread < SPREAD:
            raise SolidError(
                f"{of_material}: its stiffest strain is {spread:.1e} times as stiff as its "
                "softest, as of a nearly incompressible material; expected less than "
                f"{SPREAD:g}, as with nu up to 0.499999; frequencies are not accurate above it"
            )
        own = np.flatnonzero(plain.region == number)
        rho[own] = material.rho
        C[own] = material.stiffness_M
        if table["kind"] == "orthotropic":
            axes[number] = _axes(mesh, region, key)
            is_curved |= "axis" not in region
        names.append(region["material"])
    return CellMaterials(C, rho, tuple(names), plain.region, axes, is_curved)


def _axes(mesh: SolidMesh, region: Mapping[str, Any], key: str) -> Axes:
    """Axes of the material of a region."""
    if "axis_about" in region:
        about = region["axis_about"]
        along, point = unit(about["direction"]), np.array(about["point"])

        def around(x: Array) -> Array:
            normal = _normal_part(x - point, along, f"{key}.axis_about: a cell lies on the axis")
            return _triad(np.cross(along, normal), normal)

        return around
    normal = unit(region["normal"])
    parallel = f"{key}.normal: parallel to axis 1"
    if "axis" in region:
        first = unit(region["axis"])
        triad = _triad(first, _normal_part(normal, first, parallel))
        return lambda x: np.broadcast_to(triad, (*x.shape, 3))
    curve = Curve.of(region["axis_along"], mesh.curves, f"{key}.axis_along")

    def along_curve(x: Array) -> Array:
        first = curve.tangents(x)
        return _triad(first, _normal_part(normal, first, parallel))

    return along_curve


def _sign(vectors: Array, others: Array) -> Array:
    """Sign (k, 1) of vectors (k, 3) along others."""
    return np.where((vectors * others).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]


def _triad(first: Array, normal: Array) -> Array:
    return np.stack([first, np.cross(normal, first), normal], axis=-1)


def _normal_part(vector: Array, along: Array, problem: str) -> Array:
    """The unit vector of what of a vector is normal to another."""
    part = vector - (vector * along).sum(axis=-1, keepdims=True) * along
    length = np.linalg.norm(part, axis=-1, keepdims=True)
    if not (length > NEAR * np.linalg.norm(vector, axis=-1, keepdims=True)).all():
        raise SolidError(f"{problem}; expected another direction or place")
    return np.asarray(part / length)


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
