"""Places and directions on a shell by names of its mesh.

Named groups are the nodes of a physical point, curve or surface, with their weights. A reference
direction belongs to every cell; its projection on the cell is e1 of the laminate. A region has one
of
    axis = [x, y, z]                                   the same vector everywhere
    axis_curve = "spar"                                tangent of the nearest edge of a curve
    axis_about = {"point": [..], "direction": [..]}    around an axis: direction x (position -
                                                       point)
Without any of them, e1 follows x (y where the normal is along x). This is allowed only for
isotropic materials."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...solver.errors import check_known, few
from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.cells import corner_areas
from .shell_cells import ShellError, ShellMesh

KEYS = ("axis", "axis_curve", "axis_about")
STEEP = 0.99  # cosine between normal and x above which y is used instead
CHUNK = 2_000_000  # distances computed together


def cell_directions(
    mesh: ShellMesh, region: Mapping[str, Any], cells: IntArray, where: str
) -> Array:
    """Unit reference direction of some cells, (c, 3), in G.

    Parameters
    ----------
    mesh : of the shell
    region : table with at most one of KEYS
    cells : (c,) rows of cells
    where : key of the table, for messages

    Raises
    ------
    ShellError : more than one of the keys, a vector of length 0, unknown curve, cells on
        the axis itself.
    """
    given = [key for key in KEYS if region.get(key) is not None]
    if len(given) > 1:
        raise ShellError(f"{where}: expected one of {', '.join(KEYS)}, found {' and '.join(given)}")
    if not given:
        return _default(mesh, cells)
    key = given[0]
    place = f"{where}.{key}"
    if key == "axis":
        direction = np.tile(unit_vector(region[key], place), (len(cells), 1))
    elif key == "axis_curve":
        direction = _along_curve(mesh, str(region[key]), cells, place)
    else:
        direction = _about(mesh, region[key], cells, place)
    return direction


def vector(value: Any, where: str) -> Array:
    """Three numbers. Raises ShellError."""
    try:
        values = np.array(value, dtype=float)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (3,) or not np.all(np.isfinite(values)):
        raise ShellError(f"{where} = {value!r}: expected three numbers [x, y, z]")
    return values


def unit_vector(value: Any, where: str) -> Array:
    """Three numbers, scaled to length 1. Raises ShellError."""
    values = vector(value, where)
    length = float(np.linalg.norm(values))
    if not length > 0.0:
        raise ShellError(f"{where} = {value!r}: expected a direction, a vector longer than 0")
    return np.asarray(values / length)


def _default(mesh: ShellMesh, cells: IntArray) -> Array:
    normal = mesh.area_vectors_G[cells]
    cosine = normal[:, 0] / np.linalg.norm(normal, axis=1)
    return np.where((np.abs(cosine) > STEEP)[:, None], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])


def _along_curve(mesh: ShellMesh, name: str, cells: IntArray, where: str) -> Array:
    text = f"no physical curve of that name; the mesh has {few(mesh.curves) or 'none'}"
    check_known(name, mesh.curves, where, ShellError, text)
    first, last = np.moveaxis(mesh.points_G[mesh.curves[name]], 1, 0)
    along = last - first
    middles = mesh.centres_G[cells]
    nearest = np.empty(len(cells), dtype=np.int64)
    step = max(1, CHUNK // len(along))
    for begin in range(0, len(cells), step):
        part = slice(begin, begin + step)
        gap = middles[part, None] - first
        share = np.einsum("csx,sx->cs", gap, along) / np.einsum("sx,sx->s", along, along)
        gap -= np.clip(share, 0.0, 1.0)[..., None] * along
        nearest[part] = np.argmin(np.einsum("csx,csx->cs", gap, gap), axis=1)
    tangent = along[nearest]
    return np.asarray(tangent / np.linalg.norm(tangent, axis=1, keepdims=True))


def _about(mesh: ShellMesh, table: Any, cells: IntArray, where: str) -> Array:
    if not isinstance(table, Mapping) or set(table) != {"point", "direction"}:
        raise ShellError(f"{where} = {table!r}: expected {{point = [..], direction = [..]}}")
    point = vector(table["point"], f"{where}.point")
    axis = unit_vector(table["direction"], f"{where}.direction")
    arm = mesh.centres_G[cells] - point
    around = np.cross(axis, arm)
    length = np.linalg.norm(around, axis=1)
    on_axis = np.flatnonzero(length <= 1e-9 * mesh.size)
    if on_axis.size:
        raise ShellError(
            f"{where}: {on_axis.size} cells lie on the axis itself, where the direction "
            "around it is undefined"
        )
    return np.asarray(around / length[:, None])


class Group(NamedTuple):
    """Nodes that share a load by length of the edges, by area of the cells, or equally."""

    name: str
    kind: str  # "point", "curve" or "surface"
    nodes: IntArray  # (k,) ascending
    weights: Array  # (k,) length/2 of each edge [m], area/3 of each cell [m2], or 1 [-]
    centre_G: Array  # (3,) weighted                        [m]


def united(mesh: ShellMesh, names: str | Sequence[str], where: str) -> Group:
    """The groups with these names as one; nodes that they share have the sum of their weights.

    Parameters
    ----------
    mesh : of the shell
    names : of physical points, curves or surfaces, all of one kind
    where : key that names them, for messages

    Raises
    ------
    ShellError
        An unknown name, a name twice, groups of different kinds.
    """
    listed = [names] if isinstance(names, str) else list(names)
    parts = [group(mesh, str(name), where) for name in listed]
    if not parts or len(set(listed)) < len(listed) or len({part.kind for part in parts}) > 1:
        raise ShellError(
            f"{where} = {listed}: expected names of points, of curves or of surfaces, each once"
        )
    if len(parts) == 1:
        return parts[0]
    nodes = np.concatenate([part.nodes for part in parts])
    weights = np.concatenate([part.weights for part in parts])
    return _gathered(mesh, " + ".join(listed), parts[0].kind, nodes, weights)


def group(mesh: ShellMesh, name: str, where: str) -> Group:
    """The group with this name.

    Parameters
    ----------
    mesh : of the shell
    name : of a physical point, curve or surface
    where : key that names it, for messages

    Raises
    ------
    ShellError
        An unknown or an ambiguous name.
    """
    kinds: Mapping[str, Mapping[str, object] | tuple[str, ...]] = {
        "point": mesh.marks,
        "curve": mesh.curves,
        "surface": mesh.regions,
    }
    kinds_of_name = [kind for kind, names in kinds.items() if name in names]
    known = [str(known) for names in kinds.values() for known in names]
    text = f"no physical group of that name; the mesh has {few(known) or 'none'}"
    check_known(name, known, where, ShellError, text)
    if len(kinds_of_name) > 1:
        raise ShellError(
            f"{where} = {name!r}: a {' and a '.join(kinds_of_name)} have this name; give them "
            "different "
            "names in gmsh"
        )
    if kinds_of_name[0] == "point":
        nodes = mesh.marks[name]
        return _gathered(mesh, name, "point", nodes, np.ones(len(nodes)))
    if kinds_of_name[0] == "curve":
        ends = mesh.curves[name]
        length = np.linalg.norm(np.diff(mesh.points_G[ends], axis=1)[:, 0], axis=1)
        return _gathered(mesh, name, "curve", ends, np.repeat(length / 2.0, 2))
    nodes, shares = corner_areas(mesh.points_G, mesh.cells[mesh.region == mesh.regions.index(name)])
    return _gathered(mesh, name, "surface", nodes, shares)


def nearest_node(mesh: ShellMesh, place_G: Array) -> Group:
    """The node nearest to a position, as a group of one."""
    node = int(np.argmin(np.linalg.norm(mesh.points_G - place_G, axis=1)))
    name = "near ({:.4g}, {:.4g}, {:.4g})".format(*place_G)
    return _gathered(mesh, name, "point", np.array([node]), np.ones(1))


def _gathered(mesh: ShellMesh, name: str, kind: str, nodes: IntArray, shares: Array) -> Group:
    every = np.bincount(nodes.ravel(), weights=shares, minlength=mesh.n_node)
    unique = np.unique(nodes)
    weights = np.asarray(every[unique], dtype=float)
    centre = weights @ mesh.points_G[unique] / weights.sum()
    return Group(name, kind, unique, weights, centre)
