"""The mesh of a solid in metres, its outer faces and its exact geometry.

Cells are tetrahedra of 10 and hexahedra of 27 nodes in gmsh's order."""

import signal
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ...solver.errors import few
from ...solver.math.arrays import Array, IntArray
from ...solver.package.specification import CAD_WITH_UNIT
from .. import fenicsx
from ..fenicsx import PlainMesh
from ..fenicsx.gmsh_alone import GmshEndedError, apart
from ..fenicsx.gmsh_solid import PER_DIAGONAL, STEP, CadPart, GmshSolid, solid_from_file
from ..mesh_input import is_refused
from .step import check_step
from .tolerances import GAP, MOST


class SolidError(Exception):
    """The description of a solid is wrong, or the solid cannot be analysed."""


# Nodes in halves of the reference cell, as gmsh orders them: corners, edges, faces, centre.
_EDGES = {
    "tetrahedron": ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)),
    "hexahedron": (
        *((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3)),
        *((2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)),
    ),
}
_FACES = {  # corners, counter-clockwise seen from outside, in gmsh's order of the middle nodes
    "tetrahedron": ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)),
    "hexahedron": (
        *((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3)),
        *((1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)),
    ),
}
_CORNERS = {
    "tetrahedron": np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "hexahedron": np.array(
        [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    ),
}
CORNERS = {cell: len(corners) for cell, corners in _CORNERS.items()}
# VTK's quadratic tetrahedron, and its hexahedron of 20 nodes, from gmsh's order.
VTK = {
    "tetrahedron": (24, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    "hexahedron": (25, [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]),
}


@lru_cache
def reference_nodes(cell: str) -> Array:
    """Nodes of the reference cell, (k, 3)."""
    corners = _CORNERS[cell].astype(float)
    points = [corners, *(corners[list(e)].mean(axis=0)[None] for e in _EDGES[cell])]
    if cell == "hexahedron":
        points += [corners[list(f)].mean(axis=0)[None] for f in _FACES[cell]]
        points.append(corners.mean(axis=0)[None])
    return np.concatenate(points)


def linear_weights(cell: str) -> Array:
    """Value of the linear function of each corner at each node, (k, corners)."""
    x, corners = reference_nodes(cell), _CORNERS[cell]
    if cell == "tetrahedron":
        return np.column_stack([1.0 - x.sum(axis=1), x])
    sides = np.where(corners[None] > 0, x[:, None], 1.0 - x[:, None])
    return np.asarray(sides.prod(axis=2))


@lru_cache
def faces(cell: str) -> IntArray:
    """Local nodes of each face: corners, then the middles of its edges, (f, 6 or 8)."""
    number = {frozenset(e): len(_CORNERS[cell]) + i for i, e in enumerate(_EDGES[cell])}
    rows = []
    for face in _FACES[cell]:
        pairs = zip(face, (*face[1:], face[0]), strict=True)
        rows.append([*face, *(number[frozenset(pair)] for pair in pairs)])
    return np.array(rows)


def boundary(cells: IntArray, cell: str) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Faces of one cell only: their nodes (f, 6 or 8), cell (f,) and number in it (f,).

    And the number of the part of each cell (c,); parts have no common face.
    """
    local = faces(cell)
    nodes = cells[:, local].reshape(-1, local.shape[1])
    corners = np.sort(nodes[:, : local.shape[1] // 2], axis=1)
    _, first, face, count = np.unique(
        corners, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    own = np.sort(first[count == 1])
    size = len(cells) + len(first)
    pairs = np.repeat(np.arange(len(cells)), len(local)), len(cells) + face.ravel()
    graph = sp.coo_matrix((np.ones(len(face), dtype=np.int8), pairs), shape=(size, size))
    part = connected_components(graph, directed=False)[1][: len(cells)]
    return nodes[own], own // len(local), own % len(local), part


def derivatives(cell: str, at: Array) -> Array:
    """Derivatives of the functions of the nodes at a place of the reference cell, (3, k)."""
    ours, basix = (
        np.rint(2.0 * nodes).astype(int).tolist()
        for nodes in (reference_nodes(cell), fenicsx.reference_nodes(cell, 2))
    )
    slopes = fenicsx.lagrange(cell, 2, at[None])[1][0]
    return np.asarray(slopes[[basix.index(node) for node in ours]].T)


def face_centre(cell: str, face: int) -> Array:
    """Centre of a face in the reference cell, (3,)."""
    return np.asarray(_CORNERS[cell][list(_FACES[cell][face])].mean(axis=0))


# Size over that of the smallest cells. Quadratic cells turn inside out at much smaller radii: then
# straight ones are tried, and then smaller ones.
SMALLEST = (8.0, 16.0, 32.0)
FINER = 1.5  # size of the cells over that of the next mesh
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
    curves : ends (s, 2, 3) of the lines of each physical curve [m]
    exact : for each region what OpenCASCADE computes, empty without a CAD file
    size : of the cells of a CAD file away from small radii [m]
    """

    plain: PlainMesh
    faces: IntArray
    owner: IntArray
    local: IntArray
    groups: dict[str, IntArray]
    curves: dict[str, Array]
    exact: tuple[CadPart, ...]
    size: float

    @property
    def corners(self) -> IntArray:
        """Corners of each face, (f, 3 or 4)."""
        return self.faces[:, : self.faces.shape[1] // 2]


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
    unit = table.get("unit")
    if unit is None and path.suffix.lower() not in CAD_WITH_UNIT:
        raise SolidError(
            f'{where}.unit: missing: a {path.suffix} file has no unit of length; expected "m", '
            '"mm", "cm" or "in"'
        )
    parameters = tuple(sorted(table.get("parameters", {}).items()))
    size = size if size is not None else table.get("size")
    try:
        file = str(path), path.stat().st_mtime_ns
        if size is None:
            return _close_to_cad(*file, unit, parameters)
        return _made(*file, size, unit, parameters)
    except OSError as error:
        raise SolidError(f"{where}.file = {str(path)!r}: no such file") from error
    except (fenicsx.MeshError, SolidError) as error:
        raise SolidError(f"{where}: {error}") from error


def _apart(file: str, *how: Any) -> GmshSolid:
    """Call `solid_from_file` in a process of its own.

    OpenCASCADE and gmsh end by a signal, or split crossing edges without end, where the edges of
    a face are in no order.
    """
    try:
        return cast(GmshSolid, apart(solid_from_file, Path(file), *how))
    except GmshEndedError as error:
        end = str(error)
        if error.code < 0:
            number = signal.Signals(-error.code)
            end = f"gmsh ends by the signal {number.name}"
            end = "gmsh does not end" if number == signal.SIGXCPU else end
        raise fenicsx.MeshError(
            f"{file}: {end} while it reads or meshes the part; expected closed faces whose "
            "edges follow each other and do not cross (check and export it in the CAD program)"
        ) from None


@lru_cache(maxsize=4)
def _close_to_cad(
    file: str, changed: int, unit: float | None, parameters: tuple[Any, ...]
) -> SolidMesh:
    """The mesh with cells of the default size, or of the smaller size that its curved faces need.

    The faces of thin parts need it: cells as large as a wall turn inside out on faces that are
    curved, so that their edges stay straight.
    """
    mesh = _made(file, changed, None, unit, parameters)
    gap = _volume_gap(mesh) if mesh.exact else 0.0
    size = float(np.linalg.norm(np.ptp(mesh.plain.points, axis=0))) / PER_DIAGONAL
    while gap > GAP and 3 * len(mesh.plain.points) * FINER**3 <= MOST:
        size /= FINER
        try:
            finer = _made(file, changed, size, unit, parameters)
        except (fenicsx.MeshError, SolidError):  # the mesh that is there is sound
            break
        before, gap = gap, _volume_gap(finer)
        if gap > 0.5 * before:  # OpenCASCADE's volume may be wrong
            break
        mesh = finer
    return mesh


def _volume_gap(mesh: SolidMesh) -> float:
    """Difference of the volume of the cells from that of the CAD geometry, over the latter."""
    at, weights = fenicsx.quadrature(mesh.plain.cell, 3)  # the determinant has degree 3
    x = mesh.plain.points[mesh.plain.cells]
    volume = 0.0
    for place, weight in zip(at, weights, strict=True):
        J = np.einsum("ak,ckx->cax", derivatives(mesh.plain.cell, place), x)
        volume += weight * np.linalg.det(J).sum()
    exact = sum(part.volume for part in mesh.exact)
    return abs(volume / exact - 1.0)


@lru_cache(maxsize=4)
def _made(
    file: str, changed: int, size: float | None, unit: float | None, parameters: tuple[Any, ...]
) -> SolidMesh:
    del changed  # part of the cache key
    if Path(file).suffix.lower() in STEP:
        check_step(Path(file))
    for smallest in SMALLEST:
        mesh = _apart(file, size, unit, dict(parameters), smallest)
        plain = _right_handed(mesh.plain)
        wrong = _turned(plain)
        if not len(wrong) or not mesh.exact:
            break
        straight = _straightened(plain, wrong)
        if not len(_turned(straight)):  # a few cells of a torus or a sphere
            plain, wrong = straight, wrong[:0]
            break
    extent = np.ptp(plain.points, axis=0)
    if not extent.min() > THINNEST * extent.max():
        shown = " x ".join(f"{value:.4g}" for value in extent)
        raise SolidError(f"{file}: {shown} m; expected a solid that is thicker than 0")
    if len(wrong):
        centres = plain.points[plain.cells[wrong]].mean(axis=1)
        places = (str(np.round(x, 6).tolist()) for x in centres)
        raise SolidError(
            f"{file}: {len(wrong)} of {len(plain.cells)} cells are turned inside out, near "
            f"{few(places)} m; expected smaller cells there, or a part without these features"
        )
    nodes, owner, local, part = boundary(plain.cells, plain.cell)
    if part.any():
        raise SolidError(f"{file}: {_parts(plain, part)}")
    width = nodes.shape[1] // 2
    known = {tuple(sorted(row)): i for i, row in enumerate(nodes[:, :width].tolist())}
    groups = {}
    for name, corners in mesh.groups.items():
        found_rows = (known.get(tuple(sorted(row))) for row in corners.tolist())
        if rows := [row for row in found_rows if row is not None]:  # no face between two solids
            groups[name] = np.array(rows)
    diagonal = float(np.linalg.norm(extent))
    size = min(size or diagonal / PER_DIAGONAL, diagonal)
    return SolidMesh(plain, nodes, owner, local, groups, mesh.curves, mesh.exact, size)


def _parts(plain: PlainMesh, part: IntArray) -> str:
    """Words for parts without a common face: one edge is a hinge, more of them are no joint."""
    words, nodes = [], [np.unique(plain.cells[part == k]) for k in range(part.max() + 1)]
    for number, own in enumerate(nodes):
        names = few(plain.regions[i] for i in np.unique(plain.region[part == number]))
        low, high = (np.round(f(plain.points[own], axis=0), 6).tolist() for f in (np.min, np.max))
        words.append(f"{names} from {low} to {high} m")
    shared = np.flatnonzero(np.bincount(np.concatenate(nodes)) > 1)
    touch = (
        f"; two touch at {np.round(plain.points[shared[0]], 6).tolist()} m" if shared.size else ""
    )
    return (
        f"{len(nodes)} parts without a common face: {few(words, '; ')}{touch}; expected one body, "
        "whose cells share faces with the same nodes"
    )


def _turned(plain: PlainMesh) -> IntArray:
    """Cells that are turned inside out at a corner or at the centre."""
    nodes = reference_nodes(plain.cell)
    x = plain.points[plain.cells]
    least = np.full(len(x), np.inf)
    for place in [*nodes[: CORNERS[plain.cell]], nodes.mean(axis=0)]:
        J = np.einsum("ak,ckx->cax", derivatives(plain.cell, place), x)
        least = np.minimum(least, np.linalg.det(J))
    return np.flatnonzero(~(least > 0.0))


def _right_handed(plain: PlainMesh) -> PlainMesh:
    """The mesh in the order of gmsh if all its cells are numbered as mirror images of it."""
    if len(_turned(plain)) < len(plain.cells):
        return plain
    nodes = reference_nodes(plain.cell).tolist()
    order = [nodes.index([y, x, z]) for x, y, z in nodes]
    return replace(plain, cells=plain.cells[:, order])


def _straightened(plain: PlainMesh, wrong: IntArray) -> PlainMesh:
    """The mesh with straight edges of wrong tetrahedra, and of those that are wrong then."""
    straight = replace(plain, points=plain.points.copy())
    ends = np.array(_EDGES["tetrahedron"])
    done = np.zeros(len(plain.cells), dtype=bool)
    while not done[wrong].all():
        done[wrong] = True
        cells = plain.cells[wrong]
        straight.points[cells[:, 4:]] = plain.points[cells[:, ends]].mean(axis=2)
        wrong = _turned(straight)
    return straight


def edge_length(mesh: SolidMesh) -> float:
    """Largest but few of the edges of the outer faces [m]."""
    x: Array = mesh.plain.points[mesh.corners]
    return float(np.quantile(np.linalg.norm(x - np.roll(x, 1, axis=1), axis=2), 0.8))
