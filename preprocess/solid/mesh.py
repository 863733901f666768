"""The mesh of a solid in metres, its outer faces and its exact geometry."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ...solver.errors import few
from ...solver.math.arrays import Array, IntArray
from ...solver.package.specification import CAD, CAD_WITH_UNIT
from .. import fenicsx
from ..fenicsx import PlainMesh
from ..fenicsx.meshing.gmsh_solid import CadPart, solid_from_file
from ..python_script import is_refused
from .cells import boundary, derivatives, faces, reference_nodes
from .errors import SolidError

KINDS = (*CAD, ".geo", ".msh")
FACE_NODE = 20  # first node of a hexahedron in the middle of a face
THINNEST = 1e-6  # least extent of a solid relative to the largest


@dataclass(frozen=True, eq=False)  # equal only to itself
class SolidMesh:
    """Cells of degree 2; n nodes, c cells, f faces outside.

    Attributes
    ----------
    plain : nodes, cells in gmsh's order, region of each cell
    faces : (f, 6 or 8) nodes of each outer face, counter-clockwise from outside: corners, then
        middles
    owner : (f,) its cell
    local : (f,) its number in the cell
    groups : rows of faces by physical surface
    exact : for each region what OpenCASCADE computes, empty without a CAD file
    """

    plain: PlainMesh
    faces: IntArray
    owner: IntArray
    local: IntArray
    groups: dict[str, IntArray]
    exact: tuple[CadPart, ...]

    @property
    def corners(self) -> IntArray:
        """Corners of each face, (f, 3 or 4)."""
        return self.faces[:, : self.faces.shape[1] // 2]

    def face_nodes(self, rows: IntArray) -> IntArray:
        """All nodes of some outer faces, also those in the middle of the faces of hexahedra."""
        found = self.faces[rows].ravel()
        if self.plain.cell == "hexahedron":
            middle = self.plain.cells[self.owner[rows], FACE_NODE + self.local[rows]]
            found = np.concatenate([found, middle])
        return np.unique(found)


def solid_mesh(table: Mapping[str, Any], where: str, size: float | None = None) -> SolidMesh:
    """Make the mesh of a solid; equal requests share one mesh.

    Parameters
    ----------
    table : {"file": "part.step", "size": 0.004, "unit": 1e-3, "parameters": {...}}
    where : key of the description, for messages
    size : of the cells [m], in place of that of the table

    Raises
    ------
    SolidError : a file that is missing, has no unit or is no solid, too many unknowns.
    """
    path = Path(table["file"])
    if is_refused(path):
        raise SolidError(f"{where}.file = {str(path)!r}: expected no script with --no-scripts")
    if path.suffix.lower() not in KINDS:
        raise SolidError(f"{where}.file = {str(path)!r}: expected one of {', '.join(KINDS)}")
    unit = table.get("unit")
    if unit is None and path.suffix.lower() not in CAD_WITH_UNIT:
        raise SolidError(
            f'{where}.unit: missing: a {path.suffix} file has no unit of length; expected "m", '
            '"mm", "cm" or "in"'
        )
    parameters = tuple(sorted(table.get("parameters", {}).items()))
    size = size if size is not None else table.get("size")
    try:
        return _made(str(path), path.stat().st_mtime_ns, size, unit, parameters)
    except OSError as error:
        raise SolidError(f"{where}.file = {str(path)!r}: no such file") from error
    except (fenicsx.MeshError, SolidError) as error:
        raise SolidError(f"{where}: {error}") from error


@lru_cache(maxsize=4)
def _made(
    file: str, changed: int, size: float | None, unit: float | None, parameters: tuple[Any, ...]
) -> SolidMesh:
    del changed  # part of the cache key
    found = solid_from_file(Path(file), size, unit, dict(parameters))
    plain = found.plain
    extent = np.ptp(plain.points, axis=0)
    if not extent.min() > THINNEST * extent.max():
        shown = " x ".join(f"{value:.4g}" for value in extent)
        raise SolidError(f"{file}: {shown} m; expected a solid that is thicker than 0")
    _check_volumes(plain, file)
    nodes, owner, local = boundary(plain.cells, plain.cell)
    width = nodes.shape[1] // 2
    known = {tuple(sorted(row)): i for i, row in enumerate(nodes[:, :width].tolist())}
    groups = {}
    for name, corners in found.groups.items():
        rows = [known.get(tuple(sorted(row)), -1) for row in corners.tolist()]
        if min(rows) < 0:
            rows = [row for row in rows if row >= 0]  # faces between two solids
        if rows:
            groups[name] = np.array(rows)
    return SolidMesh(plain, nodes, owner, local, groups, found.exact)


def _check_volumes(plain: PlainMesh, file: str) -> None:
    """Raise SolidError for cells that are turned inside out at a corner or at the centre."""
    nodes = reference_nodes(plain.cell)
    at = [*nodes[: len(faces(plain.cell))], nodes.mean(axis=0)]
    x = plain.points[plain.cells]
    least = np.full(len(x), np.inf)
    size = np.linalg.norm(np.ptp(x, axis=1), axis=1) ** 3
    for place in at:
        J = np.einsum("ak,ckx->cax", derivatives(plain.cell, place), x)
        least = np.minimum(least, np.linalg.det(J) / size)
    wrong = np.flatnonzero(~(least > 0.0))
    if len(wrong):
        places = (str(np.round(x[row].mean(axis=0), 6).tolist()) for row in wrong)
        raise SolidError(
            f"{file}: {len(wrong)} of {len(x)} cells are turned inside out, near {few(places)} m; "
            "expected smaller cells there, or a part without these features"
        )


def edge_length(mesh: SolidMesh) -> float:
    """Largest but few of the edges of the outer faces [m]."""
    x: Array = mesh.plain.points[mesh.corners]
    return float(np.quantile(np.linalg.norm(x - np.roll(x, 1, axis=1), axis=2), 0.8))
