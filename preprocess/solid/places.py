"""Interfaces of a solid: outer faces on a bore, in a plane, or of a physical surface."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...solver.errors import few, nearest
from ...solver.math.arrays import Array, IntArray
from .solid_mesh import SolidError, SolidMesh

NEAR = 1e-3  # distance from the plane or cylinder relative to the size of the face


def interface_faces(mesh: SolidMesh, table: Mapping[str, Any], where: str) -> IntArray:
    """Rows of the outer faces of an interface.

    Parameters
    ----------
    mesh : of the solid
    table : of the interface, with `at`, `bore` or `plane`
    where : key of the table, for messages

    Raises
    ------
    SolidError
        There are none; the message names bores or planes that are there.
    """
    if "at" in table:
        if table["at"] not in mesh.groups:
            hint = nearest(table["at"], mesh.groups)
            raise SolidError(
                f'{where}.at = "{table["at"]}": the solid has no physical surface of this name '
                f"outside{hint}; CAD files have no names of faces: expected bore or plane"
            )
        return mesh.groups[table["at"]]
    if "bore" in table:
        return _bore(mesh, table["bore"], f"{where}.bore")
    plane = table["plane"]
    point, normal = np.array(plane["point"]), unit(plane["normal"])

    def distance(x: Array) -> Array:
        return (x - point) @ normal

    rows = _on(mesh, distance)
    if not len(rows):
        heights = distance(mesh.plain.points)
        raise SolidError(
            f"{where}.plane: no face lies in the plane through {plane['point']} m normal to "
            f"{plane['normal']}; along this normal the solid reaches from {heights.min():.6g} to "
            f"{heights.max():.6g} m of the point"
        )
    return rows


def _bore(mesh: SolidMesh, bore: Mapping[str, Any], where: str) -> IntArray:
    point, axis = np.array(bore["point"]), unit(bore["direction"])
    radius = bore["radius"]

    def from_axis(x: Array) -> Array:
        arm = x - point
        return np.linalg.norm(arm - (arm @ axis)[..., None] * axis, axis=-1)

    rows = _on(mesh, lambda x: from_axis(x) - radius)
    centres = mesh.plain.points[mesh.corners].mean(axis=1)
    if "length" in bore:
        rows = rows[np.abs((centres[rows] - point) @ axis) <= bore["length"] / 2.0]
    if len(rows):
        return rows
    radii = _radii(mesh, from_axis)
    known = (
        f"radii about this axis: {few(f'{r:.6g} m' for r in radii)}"
        if radii
        else ("no cylinder of the solid has this axis")
    )
    within = f" within {bore['length']:g} m" if "length" in bore else ""
    raise SolidError(
        f"{where}: no face lies on the cylinder of radius {radius:g} m about the axis through "
        f"{bore['point']} m along {bore['direction']}{within}; {known}"
    )


def _radii(mesh: SolidMesh, from_axis: Callable[[Array], Array]) -> list[float]:
    """Radii of faces all of whose nodes have the same distance from an axis."""
    r = from_axis(mesh.plain.points[mesh.faces])
    x = mesh.plain.points[mesh.corners]
    size = np.linalg.norm(np.ptp(x, axis=1), axis=1)
    same = np.ptp(r, axis=1) <= NEAR * size
    return sorted({float(f"{value:.6g}") for value in np.median(r[same], axis=1)})


def _on(mesh: SolidMesh, distance: Callable[[Array], Array]) -> IntArray:
    """Faces with all their nodes at distance zero."""
    x = mesh.plain.points[mesh.faces]
    size = np.linalg.norm(np.ptp(x, axis=1), axis=1)
    return np.flatnonzero(np.abs(distance(x)).max(axis=1) <= NEAR * size)


def unit(vector: list[float]) -> Array:
    """The unit vector along a vector longer than 0."""
    return np.array(vector) / np.linalg.norm(vector)
