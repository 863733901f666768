"""Stiffness and density of the cells of a solid, and the axes of its materials."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...solver.errors import few, nearest
from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.materials import material_from_dict, rotated
from .places import unit
from .solid_mesh import SolidError, SolidMesh

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
