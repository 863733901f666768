"""Meshes of cross-sections, with named regions and curves.

The mesh axes are the section's: x = x2, y = x3, origin = reference point. A mesh comes from
a script of the library (meshes/), from a gmsh script or mesh of the user, or as arrays.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.common.plain_data import canonical
from ... import fenicsx
from ...fenicsx import PlainMesh
from ..section_specification import SectionError
from .mesh_checks import checked
from .section_cells import FULL, CellMesh, cells_of_plain, filling, patterns

KEPT = 8  # meshes that a process keeps
SOURCES = ("script", "file", "arrays")
MIXED = "mixed"  # cell_type of arrays with cells (c, 9), kind (c,) and layer_angle
ARRAY_CELLS = {
    "triangle": ("triangle", 1),
    "triangle6": ("triangle", 2),
    "quad": ("quadrilateral", 1),
    "quad8": ("quadrilateral", 2),
    "quad9": ("quadrilateral", 2),
}


@dataclass(frozen=True, eq=False)  # equal only to itself
class SectionMesh:
    """The mesh of a section: cells with their regions, and named curves.

    Attributes
    ----------
    cells : the cells with their regions
    curves : physical curve -> (s, 2 or 3, 2) its line elements: end points, then the middle
        node of degree-2 ones [m]
    warnings : {"code", "message"}
    """

    cells: CellMesh
    curves: dict[str, Array]
    warnings: tuple[dict[str, str], ...] = ()


def section_mesh(spec_mesh: Mapping[str, Any], where: str) -> SectionMesh:
    """Make the mesh of a section; equal requests share one mesh.

    Parameters
    ----------
    spec_mesh : one of
        {"script": "box", "parameters": {"width": 0.02, "rows": [0.5, 1.0], ...}}, a script of the
        library with numbers or lists of numbers for its parameters (the airfoil: also
        "coordinates", pairs);
        {"file": "part.msh"} or {"file": "part.geo", "parameters": {...}};
        {"arrays": "part.npz"}, with points, cells, cell_type, region, region_names and, for
        curves, lines, curve, curve_names;
        plus optional "scale", a factor on all coordinates
    where : file and key of the description, for messages

    Raises
    ------
    SectionError : no such file, an error of gmsh, regions that overlap or are empty,
        folded cells, a section in several parts.
    """
    path = _source(spec_mesh, where)
    content = hashlib.sha256(path.read_bytes()).hexdigest()
    table = canonical(spec_mesh)
    try:
        return _made(table, str(path), content)
    except (fenicsx.MeshError, SectionError) as error:
        raise SectionError(f"{where}: {error}") from error


@lru_cache(maxsize=KEPT)
def _made(table: str, file: str, content: str) -> SectionMesh:
    spec, path = json.loads(table), Path(file)
    del content  # part of the cache key: a changed file gives another entry
    scale = float(spec.get("scale", 1.0))
    if "arrays" in spec and (mixed := _mixed_arrays(path)) is not None:
        mixed, warnings = checked(replace(mixed, points=scale * mixed.points), str(path))
        return SectionMesh(mixed, {}, tuple(warnings))
    if "arrays" in spec:
        plain = _arrays(path)
    else:
        more = (spec.get("coordinates", ()),) if path.suffix == ".py" else ()
        parameters, counted = spec.get("parameters", {}), "file" in spec
        plain = fenicsx.surface_mesh(path, parameters, 2, *more, counted=counted)
    if scale != 1.0:
        curves = {name: scale * lines for name, lines in plain.curves.items()}
        plain = replace(plain, points=scale * plain.points, curves=curves)
    cells, warnings = checked(cells_of_plain(plain), str(path))
    return SectionMesh(cells, plain.curves, tuple(warnings))


def script_path(name: str) -> Path:
    """Path of a script of the library: beside the package in a wheel, at the top of a checkout."""
    if not name.replace("-", "_").isidentifier():
        raise SectionError(f"gmsh script {name!r}: expected the name of a script of the library")
    folder = Path(__file__).parents[3] / "meshes"
    for suffix in (".geo", ".py"):
        if (folder / f"{name}{suffix}").is_file():
            return folder / f"{name}{suffix}"
    raise SectionError(f"gmsh script {name}: not found in {folder}")


def _source(spec: Mapping[str, Any], where: str) -> Path:
    given = [key for key in SOURCES if key in spec]
    if len(given) != 1:
        raise SectionError(
            f"{where}: expected one of {', '.join(SOURCES)}, found {' and '.join(given) or 'none'}"
        )
    if given[0] == "script":
        return script_path(str(spec["script"]))
    path = Path(spec[given[0]])
    if not path.is_file():
        raise SectionError(f"{where}.{given[0]} = {str(path)!r}: no such file")
    return path


def _mixed_arrays(path: Path) -> CellMesh | None:
    """Cells of several kinds with a layer angle each; None for a file of another form."""
    with np.load(path, allow_pickle=False) as file:
        if str(file["cell_type"]) != MIXED:
            return None
        data = {name: file[name] for name in file.files}
    nodes = data["cells"].astype(np.int64)
    angles = data["layer_angle"].astype(float)
    mesh = CellMesh(
        data["points"].astype(float),
        nodes,
        data["kind"].astype(np.int64),
        data["region"].astype(np.int64),
        tuple(str(region) for region in data["region_names"]),
        layer_angle=angles,
    )
    if angles.shape[1] > 1:  # as for positions, at the nodes that a cell does not have
        mesh = replace(mesh, layer_angle=_filled_angles(mesh, angles))
    return mesh


def _filled_angles(mesh: CellMesh, angles: Array) -> Array:
    out = angles.copy()
    for kind, rows in mesh.of_kinds:
        nodes = mesh.nodes[rows, : FULL[kind]]
        for pattern, members in patterns(nodes):
            full = filling(kind, pattern)
            out[rows[members], : FULL[kind]] = angles[rows[members]][:, pattern] @ full.T
    return out


def _arrays(path: Path) -> PlainMesh:
    with np.load(path, allow_pickle=False) as file:
        data = {name: file[name] for name in file.files}
    name = str(data["cell_type"])
    if name not in ARRAY_CELLS:
        raise fenicsx.MeshError(
            f"{path}: cell_type = {name!r}: expected one of {', '.join(ARRAY_CELLS)}"
        )
    shape, degree = ARRAY_CELLS[name]
    points, cells = fenicsx.used_nodes(data["points"].astype(float), data["cells"].astype(np.int64))
    if name == "quad8":
        points, cells = fenicsx.with_centre_nodes(points, cells)
    curves = {}
    for row, curve in enumerate(data.get("curve_names", ())):
        lines = data["lines"][data["curve"] == row]
        if len(lines):
            curves[str(curve)] = data["points"][lines].astype(float)
    regions = tuple(str(region) for region in data["region_names"])
    region = data["region"].astype(np.int64)
    if len(set(regions)) < len(regions):
        raise fenicsx.MeshError(f"{path}: region_names = {list(regions)}: expected each name once")
    empty = np.setdiff1d(np.arange(len(regions)), region)
    if empty.size:
        raise fenicsx.MeshError(f"{path}: region {regions[empty[0]]!r} has no cells")
    return PlainMesh(points, cells, shape, degree, region, regions, curves)
