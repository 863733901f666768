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
from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.cells import NONE, corner_counts
from ...solver.package.common.plain_data import canonical
from .. import fenicsx
from ..fenicsx import PlainMesh
from ..mesh_input import is_ours, load_script
from .shell_cells import BoolArray, Edges, ShellError, ShellMesh, Unpaired

# Other cells for a mesh: pairs of triangles as quadrilaterals, and finer meshes.
#
# Pairs are made best first; a triangle without a partner stays. A mesh gets finer by more cells
# from its script, or by each cell split in four.

# Least sine of the angles of a quadrilateral that is better than any triangles; 1 is a rectangle.
# Below it, quadrilaterals are better than triangles with sharper angles (docs/shells-accuracy.md).
SQUARE = 0.6
ROUNDING = 1e-9
FOLD = 0.9  # least cosine between the normals of the two triangles


def paired(mesh: ShellMesh) -> ShellMesh:
    """The mesh with pairs of neighbouring triangles of a region as quadrilaterals.

    A pair is refused if its angles are worse than `SQUARE` and no better than those of its two
    triangles. Sides on physical curves stay: stiffeners and links need them.
    """
    three = corner_counts(mesh.cells) == 3
    triangles, edges = mesh.cells[:, :3], mesh.edges
    ends, owner = edges.ends, edges.owner
    one, other = edges.shared.T
    both = three[owner[one]] & three[owner[other]]
    one, other = one[both], other[both]
    a, b = owner[one], owner[other]
    joined = (mesh.region[a] == mesh.region[b]) & (ends[one, 0] == ends[other, 1])
    if curves := [rows for rows in mesh.curves.values() if len(rows)]:
        joined &= ~np.isin(edges.number[one], edges.find(np.concatenate(curves)))
    opposite = [triangles[c].sum(axis=1) - ends[one].sum(axis=1) for c in (a, b)]
    quads = np.stack([ends[one, 0], opposite[1], ends[one, 1], opposite[0]], axis=1)
    quality, flat = _quality(mesh.points_G, quads)
    halves = np.minimum(*(_least_sine(mesh.points_G, triangles[c]) for c in (a, b)))
    shaped = quality > np.minimum(SQUARE, halves) + ROUNDING
    taken = np.zeros(len(mesh.cells), dtype=bool)
    partner = np.full(len(mesh.cells), NONE)
    for row in np.lexsort([np.arange(len(quality)), -np.round(quality, 9)]):
        if joined[row] and flat[row] and shaped[row] and not (taken[a[row]] or taken[b[row]]):
            taken[[a[row], b[row]]] = True
            partner[min(a[row], b[row])] = row
    kept = np.flatnonzero(~taken | (partner != NONE))
    cells = np.full((len(kept), 4), NONE)
    cells[:, : mesh.cells.shape[1]] = mesh.cells[kept]
    merged = partner[kept] != NONE
    cells[merged] = quads[partner[kept[merged]]]
    left = ~(taken[a] | taken[b])
    pairs = [
        (len(np.unique([a[rows], b[rows]])), reason)
        for rows, reason in (
            (left & joined & flat, "the angles of their pairs are no better than their own"),
            (left & joined & ~flat, "the surface is folded between them"),
            (left & ~joined, "they are of different regions, or a physical curve is between them"),
        )
    ]
    total = len(np.unique([a[left], b[left]]))
    unpaired = Unpaired(total, int(three.sum()), max(pairs)[1])
    return replace(mesh, cells=cells, region=mesh.region[kept], unpaired=unpaired)


def _turns(points: Array, cells: IntArray) -> tuple[Array, Array]:
    """Products of the two sides at each corner, of vectors (c, k, 3) and of lengths (c, k)."""
    corners = points[cells]
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    size = np.linalg.norm(after, axis=2) * np.linalg.norm(before, axis=2)
    return np.cross(after, before), np.where(size > 0.0, size, 1.0)


def _least_sine(points: Array, cells: IntArray) -> Array:
    """Least sine of the angles of triangles, (c,)."""
    turn, size = _turns(points, cells)
    return np.asarray((np.linalg.norm(turn, axis=2) / size).min(axis=1))


def _quality(points: Array, quads: IntArray) -> tuple[Array, BoolArray]:
    """Least sine of the angles, and whether the triangles are in one surface, (s,)."""
    turn, size = _turns(points, quads)
    # the two triangles have the corners 1 2 3 and 3 4 1, the diagonals half their sum
    halves = turn[:, 1], turn[:, 3]
    normal = halves[0] + halves[1]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sine = np.einsum("sci,si->sc", turn, normal) / size
    lengths = (np.linalg.norm(half, axis=1) for half in halves)
    cosine = np.einsum("si,si->s", *halves) / np.prod(list(lengths), axis=0)
    return sine.min(axis=1), cosine > FOLD


COUNT = "n_"  # scripts of meshes/shells: parameters that count the cells of a direction


def finer_parameters(path: Path, parameters: Mapping[str, Any], times: int) -> dict[str, object]:
    """Parameters of a script of the library with more cells in each direction.

    Those of other scripts may count other things. Nodes of a script lie on the surface that it
    describes; those of split cells lie between its nodes.

    Parameters
    ----------
    path : the script
    parameters : that a description gives
    times : how often the numbers of cells are doubled
    """
    defaults = load_script(path).DEFAULTS
    counts = {key: n for key, n in defaults.items() if key.startswith(COUNT)}
    counts |= {key: n for key, n in parameters.items() if key in counts}
    if not all(isinstance(n, int | float) for n in counts.values()):
        return dict(parameters)  # the script says what is wrong
    return {**parameters, **{key: n * 2**times for key, n in counts.items()}}


def split(mesh: ShellMesh) -> ShellMesh:
    """The mesh with each cell in four: at the middles of its sides, quadrilaterals at a centre.

    New nodes lie on the straight sides of the old cells. Cells keep their sense and region, four
    after four. Curves get the middles of their segments; sets of points get those of the sides and
    quadrilaterals whose corners are all in them, so that an edge named by its nodes stays whole.
    """
    cells, n, edges = mesh.cells, mesh.n_node, mesh.edges
    there = cells != NONE
    middles = np.full(cells.shape, NONE)
    middles[there] = n + edges.number
    points = [mesh.points_G, mesh.points_G[edges.nodes].mean(axis=1)]
    parts = np.full((len(cells), 4, cells.shape[1]), NONE)
    quads = there.all(axis=1) & (cells.shape[1] == 4)
    # triangles: a corner and the middles beside it, and the triangle between the middles
    c, m = cells[~quads, :3].T, middles[~quads, :3].T
    for part, corners in enumerate(
        [(c[0], m[0], m[2]), (m[0], c[1], m[1]), (m[2], m[1], c[2]), (m[0], m[1], m[2])]
    ):
        parts[~quads, part, :3] = np.stack(corners, axis=1)
    if quads.any():
        centre = n + len(edges.nodes) + np.arange(int(quads.sum()))
        points.append(mesh.points_G[cells[quads]].mean(axis=1))
        c, m = cells[quads].T, middles[quads].T
        for part in range(4):
            around = np.stack([c[part], m[part], centre, m[part - 1]], axis=1)
            parts[quads, part] = np.roll(around, part, axis=1)
    new = np.concatenate(points)
    marks = {}
    for name, rows in mesh.marks.items():
        whole = [np.isin(corners, rows).all(axis=1) for corners in (edges.nodes, cells[quads])]
        marks[name] = np.append(rows, n + np.flatnonzero(np.concatenate(whole)))
    tags = mesh.node_tags
    return replace(
        mesh,
        points_G=new,
        cells=parts.reshape(-1, cells.shape[1]),
        region=np.repeat(mesh.region, 4),
        curves={name: _halves(rows, edges, n) for name, rows in mesh.curves.items()},
        marks=marks,
        node_tags=np.concatenate([tags, tags.max() + 1 + np.arange(len(new) - n)]),
    )


def _halves(curve: IntArray, edges: Edges, n: int) -> IntArray:
    """Segments (s, 2) of a curve in halves; those that are no side of a cell stay whole."""
    row = edges.find(curve)
    middle = np.where(row < 0, curve[:, 1], n + row)
    halves = np.stack([curve[:, 0], middle, middle, curve[:, 1]], axis=1).reshape(-1, 2, 2)
    return np.asarray(halves[np.stack([row >= -1, row >= 0], axis=1)])


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
