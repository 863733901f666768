"""Solids by gmsh: CAD files (OpenCASCADE), scripts and meshes become cells of degree 2."""

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...solver.errors import few
from ...solver.math.arrays import Array, IntArray
from ...solver.package.specification import CAD, CAD_WITH_UNIT
from .gmsh_alone import allow, define, read
from .gmsh_surface import all_found, check_count, check_mesh, curves, gmsh_session, opened, physical
from .libraries import MeshError, gmsh
from .plain_mesh import PlainMesh

STEP, IGES = CAD_WITH_UNIT[:2], CAD_WITH_UNIT[2:]
GAP = 1e-5  # between faces of an IGES file that are one surface [m]
DELAUNAY = 5  # gmsh's number of this algorithm for surfaces
MOST_UNKNOWNS = 1_500_000  # of a solid: the matrices of more take tens of gigabytes
LEAST, PER_MEGABYTE, PER_UNKNOWN = 20.0, 5.0, 2e-4  # time to read and mesh a sound part [s]
PER_DIAGONAL = 20  # cells of the default size along the diagonal of the part
PER_TURN = 14  # cells around a full circle: mass and inertia to 1e-4, with 10 to 8e-4
TETRAHEDRON = np.sqrt(2.0) / 12.0  # volume of a regular one with edges 1
TRIANGLE = np.sqrt(3.0) / 4.0
PER_CELL, PER_FACE = 1.4, 1.0  # nodes of degree 2 for one tetrahedron, for one triangle outside
CELLS = {4: 1, 11: 2, 5: 1, 12: 2}  # gmsh's kinds: degree of tetrahedra, of hexahedra
QUADRATIC = {11: ("tetrahedron", 10), 12: ("hexahedron", 27)}
FACES = {2: 3, 9: 3, 3: 4, 10: 4, 16: 4}  # corners of gmsh's kinds of faces


class NotMeshedError(MeshError):
    """gmsh gives up at a volume."""


@dataclass(frozen=True)
class CadPart:
    """What OpenCASCADE computes of a volume of density 1 in its exact geometry."""

    volume: float  # [m3]
    centre: Array  # (3,) [m]
    inertia: Array  # (3, 3) about the centre [m5]


@dataclass(frozen=True)
class GmshSolid:
    """Cells of degree 2 in gmsh's order; `groups`: corners (k, 3 or 4) of named faces, as rows.

    `curves` has the ends (s, 2, 3) of the lines of physical curves [m].
    `exact` has a part for each region of a CAD file, and is empty otherwise.
    """

    plain: PlainMesh
    groups: dict[str, IntArray]
    curves: dict[str, Array]
    exact: tuple[CadPart, ...]


def solid_from_file(
    path: Path,
    size: float | None,
    metres: float | None,
    parameters: Mapping[str, Any],
    smallest: float,
) -> GmshSolid:
    """Mesh a CAD file or a script, or read a mesh.

    Parameters
    ----------
    size : of the cells [m], of a CAD file; None: the diagonal over PER_DIAGONAL
    metres : unit of length of the file [m]; None: that in a STEP or IGES file
    parameters : of a script
    smallest : size over that of the smallest cells, of small radii of a CAD file

    Raises
    ------
    MeshError : a file that is none of these, no closed volume, too many unknowns, faces that
        intersect, cells turned inside out.
    """
    if path.suffix.lower() in CAD:
        allow(LEAST + PER_MEGABYTE * path.stat().st_size / 1e6)
    for algorithm in (None, DELAUNAY):
        with _model(path, metres, parameters):
            if algorithm is not None:
                gmsh.option.setNumber("Mesh.Algorithm", algorithm)
            exact = _cad_parts(path) if path.suffix.lower() in CAD else ()
            if exact:
                _set_sizes(path, size, smallest)
            try:
                if not len(gmsh.model.mesh.getElementTypes(3)):
                    _generate(path, f"mesh.size = {size:g}" if size else "mesh.size")
                return _read(path, 1.0 if exact else metres or 1.0, exact)
            except NotMeshedError:  # at the tip of a cone, triangles of gmsh's choice may overlap
                if algorithm is not None:
                    raise
    raise AssertionError


@contextmanager
def _model(path: Path, metres: float | None, parameters: Mapping[str, Any]) -> Iterator[None]:
    """The file as the current model of gmsh."""
    if not path.is_file():
        raise MeshError(f"{path}: no such file")
    if path.suffix == ".msh":
        with opened(path):
            yield
        return
    if path.suffix == ".geo":
        check_count(path, parameters)
    with gmsh_session():
        gmsh.clear()
        try:
            if path.suffix == ".geo":
                define(parameters)
                read(str(path))
            else:
                _import(path, metres)
        except MeshError:
            raise
        except Exception as error:  # gmsh raises bare Exception or ValueError
            raise MeshError(f"{path}: gmsh: {error}") from error
        try:
            yield
        finally:
            gmsh.clear()


def _import(path: Path, metres: float | None) -> None:
    """Import a CAD file in metres; touching solids share their faces then."""
    suffix, occ = path.suffix.lower(), gmsh.model.occ
    for name, value in (
        # of all directions alike it keeps cylinders, which `dilate` would not
        ("OCCScaling", metres if metres and suffix == ".brep" else 1.0),
        ("OCCSewFaces", suffix in IGES),  # most IGES files have faces only
        ("OCCMakeSolids", suffix in IGES),
        ("Tolerance", GAP if suffix in IGES else 1e-8),
    ):
        gmsh.option.setNumber(f"Geometry.{name}", float(value))
    try:
        if suffix in IGES:  # OpenCASCADE takes no unit for them before it has read one
            gmsh.option.setString("Geometry.OCCTargetUnit", "")
            occ.importShapes(str(path))
            gmsh.clear()
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        shapes = occ.importShapes(str(path), highestDimOnly=True)  # never run as a script
        if suffix in IGES and (len(shapes) != 1 or shapes[0][0] != 3):
            shapes = _sewn_one_by_one(path)
    except Exception as error:  # gmsh raises bare Exception
        raise MeshError(f"{path}: OpenCASCADE cannot read it: {error}") from error
    gmsh.option.setNumber("Geometry.Tolerance", 1e-8)
    solids = [tag for tag in shapes if tag[0] == 3]
    if not solids:
        kinds = {2: "faces", 1: "curves", 0: "points"}
        what = ", ".join(
            f"{sum(d == k for d, _ in shapes)} {kinds[k]}" for k in {d for d, _ in shapes}
        )
        raise MeshError(
            f"{path}: no closed solid, found {what or 'nothing'}: an open shell has no inside; "
            "expected solids (export the part as a solid, and close gaps in the CAD program)"
        )
    if len(solids) > 1:
        owned = occ.fragment(solids[:1], solids[1:])[1][: len(solids)]
        pieces = [piece for own in owned for piece in own if piece[0] == 3]
        if len(pieces) > len(set(pieces)):  # also of a solid within another
            raise MeshError(
                f"{path}: {len(solids)} solids intersect; expected solids that touch, or one solid "
                "(unite them in the CAD program)"
            )
    occ.synchronize()


def _sewn_one_by_one(path: Path) -> list[tuple[int, int]]:
    """Solids of an IGES file that has only their faces, one solid behind the other.

    A solid is complete when each curve bounds its faces an even number of times.
    """
    occ = gmsh.model.occ

    def faces() -> list[tuple[int, int]]:
        gmsh.clear()
        for name in ("OCCSewFaces", "OCCMakeSolids"):
            gmsh.option.setNumber(f"Geometry.{name}", 0.0)
        shapes = occ.importShapes(str(path), highestDimOnly=True)
        occ.synchronize()
        return [tag for tag in shapes if tag[0] == 2]

    groups: list[list[tuple[int, int]]] = [[]]
    odd: list[Array] = []
    for face in faces():
        groups[-1].append(face)
        for _, curve in gmsh.model.getBoundary([face], combined=False, oriented=False):
            (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
            length = occ.getMass(1, curve)
            place = np.array([*gmsh.model.getValue(1, curve, [0.5 * (low + high)]), length])
            others = [x for x in odd if np.abs(x - place).max() > GAP]
            if length > GAP:  # not the tip of a cone
                odd = others if len(others) < len(odd) else [*odd, place]
        if not odd:
            groups.append([])
    shapes: list[tuple[int, int]] = []
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for number, group in enumerate(groups[:-1]):
            occ.remove([face for face in faces() if face not in group])
            occ.synchronize()
            files.append(f"{folder}/{number}.brep")
            gmsh.write(files[-1])
        gmsh.clear()
        for name in ("OCCSewFaces", "OCCMakeSolids"):
            gmsh.option.setNumber(f"Geometry.{name}", 1.0)
        for file in files:
            shapes += occ.importShapes(file, highestDimOnly=True)
    return shapes if not groups[-1] else [*shapes, *faces()]


def _cad_parts(path: Path) -> tuple[CadPart, ...]:
    occ, parts = gmsh.model.occ, []
    for dimension, tag in gmsh.model.getEntities(3):
        volume = float(occ.getMass(dimension, tag))
        if not volume > 0.0:
            raise MeshError(
                f"{path}: solid {tag} has the volume {volume:g} m3; expected a closed solid with "
                "its faces outwards"
            )
        J = np.reshape(occ.getMatrixOfInertia(dimension, tag), (3, 3))
        parts.append(CadPart(volume, np.array(occ.getCenterOfMass(dimension, tag)), J))
    return tuple(parts)


def _set_sizes(path: Path, size: float | None, smallest: float) -> None:
    """Sizes of cells; raise MeshError for too many, before anything is meshed."""
    box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    extent = box[1] - box[0]
    diagonal = float(np.linalg.norm(extent))
    size = min(size or diagonal / PER_DIAGONAL, diagonal)  # not larger than the part
    volume, area = (
        sum(gmsh.model.occ.getMass(d, tag) for d, tag in gmsh.model.getEntities(d)) for d in (3, 2)
    )
    _check_unknowns(volume, area, size, f"{path}: mesh.size = {size:g} m")
    for name, value in (
        ("MeshSizeMax", size),
        ("MeshSizeMin", size / smallest),
        ("MeshSizeFromCurvature", PER_TURN),
        ("MeshSizeExtendFromBoundary", 0),  # or fillets would make all cells small
    ):
        gmsh.option.setNumber(f"Mesh.{name}", value)


def _check_unknowns(volume: float, area: float, size: float, what: str) -> None:
    cells, faces = volume / (TETRAHEDRON * size**3), area / (TRIANGLE * size**2)
    count = 3.0 * (PER_CELL * cells + PER_FACE * faces)
    if count > MOST_UNKNOWNS:
        raise MeshError(
            f"{what}: about {count:.1e} unknowns; expected at most {MOST_UNKNOWNS}: larger cells, "
            "or a part without small features"
        )
    allow(LEAST + PER_UNKNOWN * count)


def _generate(path: Path, key: str) -> None:
    """Mesh the volumes of the current model."""
    try:
        gmsh.model.mesh.generate(2)
        _check_surface(path, key)
        gmsh.model.mesh.generate(3)
    except MeshError:
        raise
    except Exception as error:  # gmsh raises bare Exception
        raise NotMeshedError(
            f"{path}: gmsh cannot mesh its volume: {error}; expected faces that do not intersect, "
            "and walls thicker than 0"
        ) from error
    if not len(gmsh.model.mesh.getElementTypes(3)):
        raise MeshError(f"{path}: gmsh made no solid cells; expected a closed volume")


def _check_surface(path: Path, key: str) -> None:
    """Number of unknowns from the mesh of the surface, before the volume is meshed."""
    tags, places, _ = gmsh.model.mesh.getNodes()
    x = np.empty((int(max(tags, default=0)) + 1, 3))
    x[tags.astype(int)] = np.reshape(places, (-1, 3))
    corners = gmsh.model.mesh.getElementsByType(2)[1].astype(int).reshape(-1, 3)
    if not len(corners):
        return
    a, b, c = (x[corners[:, k]] for k in range(3))
    normals = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    volume = float(np.prod(np.ptp(x[corners.ravel()], axis=0)))
    entities = gmsh.model.getEntities(3)
    if path.suffix.lower() in CAD:
        volume = sum(gmsh.model.occ.getMass(d, tag) for d, tag in entities)
    size = float(np.sqrt((areas @ areas) / areas.sum() / TRIANGLE))  # inside, far from features
    _check_unknowns(volume, float(len(areas)) * TRIANGLE * size**2, size, f"{path}: {key}")


def _read(path: Path, metres: float, exact: tuple[CadPart, ...]) -> GmshSolid:
    """The current model as arrays in metres."""
    groups = _volume_groups(path)
    kinds, cells, _ = gmsh.model.mesh.getElements(3)
    whole = all_found(cells, "Tetrahedra", "Hexahedra")
    if len(kinds) != 1 or kinds[0] not in CELLS or not whole:
        names = few(gmsh.model.mesh.getElementProperties(kind)[0] for kind in kinds)
        raise MeshError(
            f"{path}: has {names or 'no solid cells'}; expected tetrahedra (4 or 10 nodes) or "
            "hexahedra (8 or 27 nodes), one kind and degree only"
        )
    if CELLS[kinds[0]] == 1:
        gmsh.model.mesh.setOrder(2)
        (kind,) = (int(k) for k in gmsh.model.mesh.getElementTypes(3))
    else:
        (kind,) = kinds
    shape, width = QUADRATIC[kind]
    tables = [
        [np.reshape(gmsh.model.mesh.getElementsByType(kind, t)[1], (-1, width)) for t in own]
        for own in groups.values()
    ]
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    labels = np.concatenate([t for own in tables for t in own]).astype(np.int64)
    used = np.unique(labels)
    if 3 * len(used) > MOST_UNKNOWNS:
        raise MeshError(
            f"{path}: {3 * len(used)} unknowns; expected at most {MOST_UNKNOWNS}: larger cells"
        )
    order = np.argsort(tags)
    known = np.asarray(tags, dtype=np.int64)[order]
    points = np.reshape(coordinates, (-1, 3))[order[np.searchsorted(known, used)]]
    cells = np.searchsorted(used, labels)
    check_mesh(points, used, cells[:, : 4 if shape == "tetrahedron" else 8], str(path))
    plain = PlainMesh(
        points=metres * points,
        cells=cells,
        cell=shape,
        degree=2,
        region=np.repeat(np.arange(len(groups)), [sum(map(len, own)) for own in tables]),
        regions=tuple(groups),
    )
    ends = curves(known, metres * np.reshape(coordinates, (-1, 3))[order], 3)
    lines = {name: line[:, :2] for name, line in ends.items()}
    return GmshSolid(plain, _face_groups(used), lines, exact)


def _volume_groups(path: Path) -> dict[str, list[int]]:
    """Volumes by physical group; without groups, by their names in the CAD file, or numbers."""
    groups = physical(3)
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    if not groups:
        for tag in volumes:
            name = gmsh.model.getEntityName(3, tag).rpartition("/")[2] or f"solid {tag}"
            groups[f"{name} {tag}" if name in groups else name] = [tag]
        return groups
    for tag in volumes:
        names = [name for name, own in groups.items() if tag in own]
        if len(names) != 1:
            raise MeshError(
                f"{path}: volume {tag} is in {len(names)} physical groups ({few(names)}); expected "
                "exactly one, the region of its material"
            )
    return groups


def _face_groups(used: IntArray) -> dict[str, IntArray]:
    """Corners of the faces of every physical surface, rows of the used nodes."""
    groups: dict[str, IntArray] = {}
    for name, entities in physical(2).items():
        tables = []
        for entity in entities:
            kinds, _, nodes = gmsh.model.mesh.getElements(2, entity)
            for kind, table in zip(kinds, nodes, strict=True):
                width = gmsh.model.mesh.getElementProperties(kind)[3]
                corners = np.reshape(table, (-1, width))[:, : FACES[int(kind)]].astype(np.int64)
                tables.append(np.searchsorted(used, corners).clip(max=len(used) - 1))
        if tables:
            groups[name] = np.concatenate(tables)
    return groups
