"""Read the current gmsh model as plain arrays."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import MeshError
from ..plain import IntArray, NamedNodes, PlainMesh, with_centre_nodes
from ..stack import Array, gmsh

CELLS = {
    2: ("triangle", 1, 3),
    3: ("quadrilateral", 1, 4),
    9: ("triangle", 2, 6),
    10: ("quadrilateral", 2, 9),
    16: ("quadrilateral", 2, 8),  # serendipity
}
SURFACE = ("mixed", 1, 4)  # triangles have -1 as fourth node
LINES = {1: 2, 8: 3}


def plain_from_model(where: str, gdim: int = 2) -> PlainMesh:
    """Read the surfaces of the current gmsh model, each in one physical group, and named curves.

    Raises
    ------
    MeshError : solid cells, cells of a degree above 2, surfaces in no or in two physical groups,
        groups without cells; if gdim is 2, nodes outside the plane z = 0. Triangles and
        quadrilaterals of degree 1 may be mixed: see `SURFACE`.
    """
    _check_kinds(where)
    tags, every = _nodes()
    groups = _surface_groups(where)
    _check_membership(groups, where)
    kinds = sorted(int(kind) for kind in gmsh.model.mesh.getElementTypes(2))
    shape, degree, n_node = CELLS[kinds[0]] if len(kinds) == 1 else SURFACE
    parts, rows = [], []
    for row, (name, entities) in enumerate(groups.items()):
        found = [_cells(kind, entities, n_node) for kind in kinds]
        if not any(len(nodes) for nodes in found):
            raise MeshError(f"{where}: physical surface {name!r} has no cells")
        parts += found
        rows.append(np.full(sum(map(len, found)), row))
    labels = np.concatenate(parts)
    used = np.searchsorted(tags, np.unique(labels[labels >= 0]))
    position = np.full(len(tags), -1)
    position[used] = np.arange(len(used))
    at = position[np.searchsorted(tags, np.maximum(labels, tags[0]))]
    cells = np.where(labels < 0, -1, at)
    check_finite(every[used], tags[used], where)
    points = _in_plane(every[used], where) if gdim == 2 else every[used]
    if n_node == 8:
        points, cells = with_centre_nodes(points, cells)
    named_curves = curves(tags, every, gdim)
    named = _named_nodes(tags, used)
    return PlainMesh(
        points, cells, shape, degree, np.concatenate(rows), tuple(groups), named_curves, named
    )


def _cells(kind: int, entities: Sequence[int], width: int) -> IntArray:
    """Node numbers of all cells of a kind, (c, width), filled with -1."""
    tables = [gmsh.model.mesh.getElementsByType(kind, entity)[1] for entity in entities]
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *tables]).astype(np.int64)
    nodes = nodes.reshape(-1, CELLS[kind][2])
    return np.pad(nodes, ((0, 0), (0, width - nodes.shape[1])), constant_values=-1)


def _check_kinds(where: str) -> None:
    if len(gmsh.model.mesh.getElementTypes(3)):
        raise MeshError(f"{where}: has solid (3-D) cells, expected a mesh of surfaces only")
    kinds = [int(kind) for kind in gmsh.model.mesh.getElementTypes(2)]
    if not kinds:
        raise MeshError(f"{where}: has no surface cells")
    for kind in kinds:
        if kind not in CELLS:
            name = gmsh.model.mesh.getElementProperties(kind)[0]
            raise MeshError(
                f"{where}: has cells of kind {name!r}, expected triangles or quadrilaterals of "
                "degree 1 or 2 (gmsh: Mesh.ElementOrder = 2;)"
            )
    if set(kinds) == {2, 3}:
        return
    if len({CELLS[kind][0] for kind in kinds}) > 1:
        count = {CELLS[kind][0]: 0 for kind in kinds}
        for kind in kinds:
            count[CELLS[kind][0]] += len(gmsh.model.mesh.getElementsByType(kind)[0])
        raise MeshError(
            f"{where}: mixes {count['triangle']} triangles and {count['quadrilateral']} "
            "quadrilaterals: only those of degree 1 may be mixed. In gmsh, remove every "
            "`Recombine` for triangles only, or set Mesh.SubdivisionAlgorithm = 1;"
        )
    if len(kinds) > 1:
        raise MeshError(f"{where}: mixes cells of degree 1 and 2, or with 8 and 9 nodes")


def _surface_groups(where: str) -> dict[str, list[int]]:
    """Physical surfaces and their entities; raises MeshError if there are none."""
    groups = physical(2)
    if not groups:
        raise MeshError(
            f"{where}: no physical surface, expected one for each region, such as "
            'Physical Surface("section") = {1}; (and no Mesh.SaveAll when saving)'
        )
    return groups


def physical(dimension: int) -> dict[str, list[int]]:
    """Physical groups by name, or by number if unnamed, and their entities."""
    return {
        gmsh.model.getPhysicalName(dimension, tag) or str(tag): [
            int(entity) for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)
        ]
        for _, tag in gmsh.model.getPhysicalGroups(dimension)
    }


def _check_membership(groups: Mapping[str, Sequence[int]], where: str) -> None:
    """Check that every surface with cells is in exactly one group; gmsh returns cells by group."""
    members: dict[int, list[str]] = {}
    for name, entities in groups.items():
        for entity in entities:
            members.setdefault(entity, []).append(name)
    for _, entity in gmsh.model.getEntities(2):
        names = members.get(entity, [])
        if len(names) == 1 or not len(gmsh.model.mesh.getElements(2, entity)[0]):
            continue
        box = gmsh.model.getBoundingBox(2, entity)
        place = (
            f"surface {entity}, from ({box[0]:.4g}, {box[1]:.4g}) to ({box[3]:.4g}, {box[4]:.4g}),"
        )
        listed = ": " + " and ".join(map(repr, names)) if names else ""
        raise MeshError(
            f"{where}: {place} is in {len(names)} physical groups{listed}; expected exactly one, "
            "the region of its material"
        )


def check_finite(points: Array, tags: IntArray, where: str) -> None:
    """Raise MeshError for a coordinate that is not finite; `tags` are the numbers of the file."""
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if wrong.size:
        raise MeshError(
            f"{where}: node {tags[wrong[0]]} at {points[wrong[0]].tolist()}: expected finite "
            f"coordinates; wrong nodes: {wrong.size}"
        )


def _in_plane(points: Array, where: str) -> Array:
    """The x, y of points that must lie on z = 0, (n, 2)."""
    size = float(np.ptp(points[:, :2], axis=0).max())
    far = int(np.argmax(np.abs(points[:, 2])))
    if not abs(points[far, 2]) <= 1e-9 * size:
        x, y, z = points[far]
        raise MeshError(
            f"{where}: node at ({x:.4g}, {y:.4g}, {z:.4g}) is not in the plane z = 0; a section is "
            "meshed with x = x2, y = x3 and z = 0"
        )
    return np.ascontiguousarray(points[:, :2])


def _nodes() -> tuple[IntArray, Array]:
    """Numbers of all nodes, ascending, and their positions (n, 3)."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    return np.asarray(tags, dtype=np.int64)[order], np.reshape(coordinates, (-1, 3))[order]


def curves(tags: IntArray, points: Array, gdim: int) -> dict[str, Array]:
    """Line elements of every physical curve by name."""
    lines = {n: _lines(entities, tags, points, gdim) for n, entities in physical(1).items()}
    return {name: ends for name, ends in lines.items() if ends.size}


def _lines(entities: Sequence[int], tags: IntArray, points: Array, gdim: int) -> Array:
    """Line elements of some curves; none if their degrees are mixed."""
    rows = np.searchsorted(tags, _line_tags(entities))
    return np.asarray(points[rows, :gdim])


def _line_tags(entities: Sequence[int]) -> IntArray:
    """Node numbers of the line elements of some curves, (s, 2 or 3)."""
    pieces = []
    for entity in entities:
        kinds, _, nodes = gmsh.model.mesh.getElements(1, entity)
        for kind, table in zip(kinds, nodes, strict=True):
            if kind in LINES:
                pieces.append(np.reshape(table, (-1, LINES[kind])))
    if len({piece.shape[1] for piece in pieces}) != 1:
        return np.zeros((0, 2), dtype=np.int64)
    return np.concatenate(pieces).astype(np.int64)


def _named_nodes(tags: IntArray, used: IntArray) -> NamedNodes:
    """Nodes of physical curves and points, as rows of the nodes that cells use."""
    row = np.full(len(tags), -1)
    row[used] = np.arange(len(used))
    curves, points = {}, {}
    for name, entities in physical(1).items():
        curves[name] = row[np.searchsorted(tags, _line_tags(entities))]
    for _, tag in gmsh.model.getPhysicalGroups(0):
        name = gmsh.model.getPhysicalName(0, tag) or str(tag)
        nodes = gmsh.model.mesh.getNodesForPhysicalGroup(0, tag)[0].astype(np.int64)
        points[name] = row[np.searchsorted(tags, nodes)]
    return NamedNodes(tags[used], curves, points)
