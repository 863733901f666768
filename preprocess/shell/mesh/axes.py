"""Reference direction of every cell. Its projection on the cell is e1 of the laminate.

A region has one of
    axis = [x, y, z]                                   the same vector everywhere
    axis_curve = "spar"                                tangent of the nearest edge of a curve
    axis_about = {"point": [..], "direction": [..]}    around an axis: direction x (position -
    point)
Without any of them, e1 follows x (y where the normal is along x). This is allowed only for
isotropic materials.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....solver.errors import did_you_mean, few
from ....solver.math.arrays import Array, IntArray
from ..errors import ShellError
from .mesh import ShellMesh

KEYS = ("axis", "axis_curve", "axis_about")
STEEP = 0.99  # cosine between normal and x above which y is used instead
CHUNK = 2_000_000  # distances computed together


def cell_directions(
    mesh: ShellMesh, region: Mapping[str, Any], cells: IntArray, where: str
) -> Array:
    """Unit reference direction of some cells, (c, 3), in G.

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
        found = np.array(value, dtype=float)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (3,) or not np.all(np.isfinite(found)):
        raise ShellError(f"{where} = {value!r}: expected three numbers [x, y, z]")
    return found


def unit_vector(value: Any, where: str) -> Array:
    """Three numbers, scaled to length 1. Raises ShellError."""
    found = vector(value, where)
    length = float(np.linalg.norm(found))
    if not length > 0.0:
        raise ShellError(f"{where} = {value!r}: expected a direction, a vector longer than 0")
    return np.asarray(found / length)


def _default(mesh: ShellMesh, cells: IntArray) -> Array:
    normal = mesh.area_vectors_G[cells]
    cosine = normal[:, 0] / np.linalg.norm(normal, axis=1)
    return np.where((np.abs(cosine) > STEEP)[:, None], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])


def _along_curve(mesh: ShellMesh, name: str, cells: IntArray, where: str) -> Array:
    if name not in mesh.curves:
        raise ShellError(
            f"{where} = {name!r}: no physical curve of that name; the mesh has "
            + (few(mesh.curves) or "none")
            + did_you_mean(name, mesh.curves)
        )
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
