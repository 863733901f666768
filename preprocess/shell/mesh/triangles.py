"""Geometry of flat triangles in their axes, which are those of the laminate.

Sides run 1-2, 2-3, 3-1, always from corner START[k] to corner END[k]. The formulas of the elements
do not depend on the direction of the corners about e3, so a region may reverse its normals.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ....solver.math.arrays import Array, IntArray
from ..errors import CellError

START, END = (0, 1, 2), (1, 2, 0)  # corners of the three sides
# Integration points in area coordinates, weight area / 3 each: exact up to degree 2.
POINTS = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)

BoolArray = NDArray[np.bool_]
FLAT = 1e-10  # relative to the longest side squared: a smaller area counts as zero
STEEP = 1e-6  # sine of the smallest angle between a reference direction and a normal
NAMED = 5  # cells named in a message
NORMAL = "is normal to its reference direction"


@dataclass(frozen=True)
class Triangles:
    """Some triangles, c of them.

    Attributes
    ----------
    xy_E : (c, 3, 2) corners from the centroid [m]
    A_GE : (c, 3, 3) rotation, v_G = A_GE v_E
    area : (c,) [m2]
    length : (c, 3) of the sides [m]
    tangent : (c, 3, 2) unit vectors along the sides, in E
    """

    xy_E: Array
    A_GE: Array
    area: Array
    length: Array
    tangent: Array

    def __len__(self) -> int:
        return len(self.area)

    def __getitem__(self, some: slice | IntArray) -> "Triangles":
        """Some of the triangles."""
        return Triangles(*(getattr(self, field.name)[some] for field in fields(self)))

    @property
    def interpolation(self) -> Array:
        """Functions of the corners at the integration points, (3, 3)."""
        return POINTS

    @property
    def corners_G(self) -> Array:
        """Corners from the centroid in G, (c, 3, 3) [m]."""
        return np.asarray(self.xy_E @ np.swapaxes(self.A_GE[:, :, :2], 1, 2))

    @property
    def weight(self) -> Array:
        """Area of each integration point, (c, 3) [m2]."""
        return np.repeat(self.area / 3.0, 3).reshape(-1, 3)


def triangles(
    points_G: Array, cells: IntArray, direction_G: Array, flip: Array | bool = False
) -> Triangles:
    """Geometry of triangles given by their corners.

    Parameters
    ----------
    points_G : (n, 3) nodes [m]
    cells : (c, 3) nodes of each triangle; their order gives the normal, right-handed
    direction_G : (3,) or (c, 3) reference direction; its projection onto a triangle is e1
    flip : bool or (c,), True where the normal e3 is reversed

    Raises
    ------
    ShellError
        for a triangle without area, or with the reference direction as its normal
    """
    corners = np.asarray(points_G, dtype=float)[np.asarray(cells)]
    edge = corners[:, END] - corners[:, START]
    length = np.linalg.norm(edge, axis=2)
    normal = np.cross(edge[:, 0], edge[:, 1])
    twice_area = np.linalg.norm(normal, axis=1)
    longest = length.max(axis=1, initial=0.0)
    # "not greater" catches NaN as well
    refuse(~(twice_area > FLAT * longest**2), "has no area", cells)
    e3 = normal / twice_area[:, None]
    e3 = np.where(np.asarray(flip)[..., None], -e3, e3)
    A_GE, along = projected_axes(e3, direction_G)
    refuse(~along, NORMAL, cells)
    xy_E = (corners - corners.mean(axis=1, keepdims=True)) @ A_GE[:, :, :2]
    edge_E = xy_E[:, END] - xy_E[:, START]
    return Triangles(xy_E, A_GE, 0.5 * twice_area, length, edge_E / length[..., None])


def projected_axes(e3: Array, direction_G: Array) -> tuple[Array, BoolArray]:
    """Axes A_GE (c, 3, 3) with e1 the projection of a direction, and where it has one, (c,) bool.

    Parameters
    ----------
    e3 : (c, 3) unit normals
    direction_G : (3,) or (c, 3)
    """
    e1 = np.broadcast_to(np.asarray(direction_G, dtype=float), e3.shape)
    whole = np.linalg.norm(e1, axis=1)
    e1 = e1 - np.einsum("ci,ci->c", e1, e3)[:, None] * e3
    projected = np.linalg.norm(e1, axis=1)
    along: BoolArray = projected > STEEP * whole
    e1 = e1 / np.where(along, projected, 1.0)[:, None]
    return np.stack([e1, np.cross(e3, e1), e3], axis=2), along


def refuse(wrong: BoolArray, fault: str, cells: IntArray) -> None:
    """Raise `CellError` with the first wrong cells, if any."""
    if not wrong.any():
        return
    found = np.flatnonzero(wrong)
    listed = ", ".join(f"{i} (nodes {', '.join(map(str, cells[i]))})" for i in found[:NAMED])
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    kind = "triangles" if cells.shape[1] == 3 else "quadrilaterals"
    raise CellError(f"each of these {kind} {fault}: {listed}{more}", kind, fault, found)
