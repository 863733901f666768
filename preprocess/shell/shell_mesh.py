"""Surface meshes of three-node triangles and four-node quadrilaterals, from a gmsh file or script.

Nodes and cells keep the numbering of the mesh file.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ...solver.errors import check_known
from ...solver.math.arrays import IntArray
from ...solver.package.common.plain_data import canonical
from .. import fenicsx
from ..fenicsx import PlainMesh
from ..mesh_input import is_ours
from .refinement import finer_parameters, paired, split
from .shell_cells import ShellError, ShellMesh

FEW = 300.0  # cells of a direction of a script of meshes/shells that need no check
KEPT = 8  # meshes that a process keeps
KEYS = ("file", "parameters", "scale", "element", "refine", "sha256")
ELEMENTS = ("triangle", "quadrilateral")
FARTHEST = 1e30  # [m], of a coordinate: products of larger ones may be no numbers


def shell_mesh(spec_mesh: Mapping[str, Any], where: str) -> ShellMesh:
    """Make the mesh of a shell; equal requests share one mesh.

    Parameters
    ----------
    spec_mesh : {"file": "part.msh" | "part.geo" | "part.py", "parameters": {...}, "scale": 1.0,
        "element": "quadrilateral", "refine": 1}.
        A .geo has DefineConstant entries "Parameters/<key>"; a .py has build(gmsh, parameters)
        that fills the current model and may leave meshing to the caller. With this element, pairs
        of triangles become quadrilaterals. `refine` makes the mesh finer so many times, each time
        with four cells for one (refinement.py).
    where : file and key of the description, for messages

    Raises
    ------
    ShellError : no such file, curved or solid cells, surfaces in no physical
        group, nodes of a physical group in no cell.
    """
    path = Path(str(spec_mesh.get("file", "")))
    if not path.is_file():
        raise ShellError(f"{where}.file = {str(path)!r}: no such file")
    scale = spec_mesh.get("scale", 1.0)
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not scale > 0.0:
        raise ShellError(f"{where}.scale = {scale!r}: expected a number above 0")
    element = spec_mesh.get("element")
    if element is not None:
        check_known(element, ELEMENTS, f"{where}.element", ShellError)
    refine = spec_mesh.get("refine", 0)
    if isinstance(refine, bool) or not isinstance(refine, int) or refine < 0:
        raise ShellError(f"{where}.refine = {refine!r}: expected an integer of at least 0")
    content = hashlib.sha256(path.read_bytes()).hexdigest()
    table = canonical(spec_mesh)
    try:
        return _made(table, str(path), content)
    except (fenicsx.MeshError, ShellError) as error:
        raise ShellError(f"{where}: {error}") from error


@lru_cache(maxsize=KEPT)
def _made(table: str, file: str, content: str) -> ShellMesh:
    del content  # part of the cache key: a changed file gives another entry
    spec, path = json.loads(table), Path(file)
    parameters, left = spec.get("parameters", {}), spec.get("refine", 0)
    if left and path.suffix == ".py" and is_ours(path):
        parameters, left = finer_parameters(path, parameters, left), 0
    numbers = [n for n in parameters.values() if isinstance(n, int | float)]
    counted = not is_ours(path) or max(numbers, default=0.0) > FEW
    plain = fenicsx.surface_mesh(path, parameters, 3, counted=counted)
    scale, element = float(spec.get("scale", 1.0)), spec.get("element")
    mesh = mesh_of(replace(plain, points=scale * plain.points), str(path))
    if element == "triangle" and plain.cell != "triangle":
        raise ShellError('element = "triangle", but the mesh has quadrilaterals; remove `element`')
    if element == "quadrilateral" and plain.cell != "quadrilateral":
        mesh = paired(mesh)
    fenicsx.check_size(len(mesh.cells) * 4**left, f"{path}: refine = {left}")
    for _ in range(left):
        mesh = split(mesh)
    return mesh


def mesh_of(plain: PlainMesh, where: str = "mesh") -> ShellMesh:
    """The mesh of plain cells in space. Raises ShellError for cells of degree 2."""
    if plain.degree != 1:
        raise ShellError(
            f"{where}: has {plain.cell}s of degree {plain.degree}, expected three-node triangles "
            "or four-node quadrilaterals. In gmsh, set Mesh.ElementOrder = 1"
        )
    wrong = np.flatnonzero(~(np.abs(plain.points) <= FARTHEST).all(axis=1))
    if wrong.size:
        tag = wrong[0] + 1 if plain.named is None else plain.named.tags[wrong[0]]
        raise ShellError(
            f"{where}: node {tag} at {plain.points[wrong[0]].tolist()}: expected three finite "
            f"coordinates of at most {FARTHEST:g} m; wrong nodes: {wrong.size}"
        )
    named = plain.named
    curves = {} if named is None else named.curves
    marks = {} if named is None else named.points
    return ShellMesh(
        points_G=plain.points,
        cells=plain.cells,
        region=plain.region,
        regions=plain.regions,
        curves={name: _known(rows, name, where) for name, rows in curves.items()},
        marks={name: _known(rows, name, where) for name, rows in marks.items()},
        node_tags=np.arange(1, len(plain.points) + 1) if named is None else named.tags,
    )


def _known(rows: IntArray, name: str, where: str) -> IntArray:
    """Nodes of a physical group. Raises ShellError for those of no cell."""
    if np.any(rows < 0):
        raise ShellError(
            f"{where}: {np.count_nonzero(rows < 0)} nodes of physical group {name!r} belong to no "
            "cell, so they have no stiffness. In gmsh, let the surface contain the entity "
            "(`Point{..} In Surface{..}`, BooleanFragments), or remove it from the group"
        )
    return rows
