"""Geometry of quadrilaterals in the axes of their laminate; warped ones by their mean plane."""

from dataclasses import dataclass, fields

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import NONE, area_vectors, corner_counts
from .edges import Edges
from .triangles import FLAT, NORMAL, BoolArray, projected_axes, refuse


def width_ratios(points_G: Array, cells: IntArray) -> Array:
    """L^2/H^2 of each side of each cell, (c, 4) or (c, 3); 0 for sides of triangles."""
    ratios = np.zeros(cells.shape)
    if cells.shape[1] == 3:
        return ratios
    edges = Edges(cells)
    length = np.linalg.norm(np.diff(points_G[edges.ends], axis=1)[:, 0], axis=1)
    width = np.linalg.norm(area_vectors(points_G, cells), axis=1)[edges.owner] / length
    mean = (edges.sums(width) / edges.count)[edges.number]
    beside = edges.sums(corner_counts(cells)[edges.owner] == 3)[edges.number] > 0
    ratios[cells != NONE] = np.where(beside, 0.0, (length / mean) ** 2)
    return ratios


START, END = (0, 1, 2, 3), (1, 2, 3, 0)
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
GAUSS = CORNERS / np.sqrt(3.0)  # 2 x 2 points, weight 1 each


def shape(points: Array) -> Array:
    """Bilinear functions N at points (q, 2) of (xi, eta), (q, 4)."""
    return np.asarray(0.25 * (1.0 + points[:, None] * CORNERS).prod(axis=2))


def slopes(points: Array) -> Array:
    """Derivatives of N by xi and eta, (q, 4, 2)."""
    factors = 1.0 + points[:, None] * CORNERS
    return 0.25 * CORNERS * factors[:, :, ::-1]


AT_GAUSS = shape(GAUSS)
CENTRE = slopes(np.zeros((1, 2)))[0]


@dataclass(frozen=True)
class Quadrilaterals:
    """Some quadrilaterals, c of them, projected on their mean planes.

    Attributes
    ----------
    xy_E : (c, 4, 2) corners from the centroid of the area [m]
    height : (c, 4) of the corners above the mean plane, along e3 [m]
    A_GE : (c, 3, 3) rotation, v_G = A_GE v_E
    area : (c,) [m2]
    length : (c, 4) of the sides [m]
    tangent : (c, 4, 2) unit vectors along the sides, in E
    weight : (c, 4) area of each point of `GAUSS` [m2]
    width_ratio : (c, 4) length over width, squared, of each side (side_widths.py)
    """

    xy_E: Array
    height: Array
    A_GE: Array
    area: Array
    length: Array
    tangent: Array
    weight: Array
    width_ratio: Array

    def __len__(self) -> int:
        return len(self.area)

    def __getitem__(self, some: slice | IntArray) -> "Quadrilaterals":
        """Some of the quadrilaterals."""
        return Quadrilaterals(*(getattr(self, field.name)[some] for field in fields(self)))

    @property
    def interpolation(self) -> Array:
        """Functions of the corners at the integration points, (4, 4)."""
        return AT_GAUSS

    @property
    def corners_G(self) -> Array:
        """Corners from the centroid of the area in the mean plane, in G, (c, 4, 3) [m]."""
        local = np.concatenate([self.xy_E, self.height[..., None]], axis=2)
        return np.asarray(local @ np.swapaxes(self.A_GE, 1, 2))


def quadrilaterals(
    points_G: Array,
    cells: IntArray,
    direction_G: Array,
    flip: Array | bool = False,
    width_ratio: Array | float = 0.0,
) -> Quadrilaterals:
    """Geometry of quadrilaterals given by their corners; arguments as of `triangles`.

    Raises
    ------
    ShellError
        for a cell without area, with an angle of 180 degrees or more, crossed sides, or with the
        reference direction as its normal
    """
    cells = np.asarray(cells)
    corners = np.asarray(points_G, dtype=float)[cells]
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    normal = np.cross(*diagonals)
    twice_area = np.linalg.norm(normal, axis=1)
    longest = np.max([np.linalg.norm(d, axis=1) for d in diagonals], axis=0, initial=0.0)
    refuse(~(twice_area > FLAT * longest**2), "has no area", cells)
    e3 = normal / twice_area[:, None]
    e3 = np.where(np.asarray(flip)[..., None], -e3, e3)
    A_GE, along = projected_axes(e3, direction_G)
    refuse(~along, NORMAL, cells)
    local = (corners - corners.mean(axis=1, keepdims=True)) @ A_GE
    xy = local[:, :, :2]
    turned = np.where(np.asarray(flip), -1.0, 1.0)  # sense of the corners about e3
    size = _areas(xy, turned)
    convex: BoolArray = np.asarray((size > 0.0).all(axis=1))
    refuse(~convex, "has an angle of 180 degrees or more", cells)
    area = size.sum(axis=1)
    xy = xy - ((size @ AT_GAUSS)[:, None] @ xy) / area[:, None, None]
    edge = xy[:, END] - xy[:, START]
    length = np.linalg.norm(edge, axis=2)
    return Quadrilaterals(
        xy_E=xy,
        height=np.ascontiguousarray(local[:, :, 2]),
        A_GE=A_GE,
        area=area,
        length=length,
        tangent=edge / length[..., None],
        weight=size,
        width_ratio=np.broadcast_to(np.asarray(width_ratio, dtype=float), length.shape),
    )


def _areas(xy: Array, turned: Array) -> Array:
    """Area of each point (c, 4); not positive anywhere if the mapping is not so at a corner."""
    at_points, at_corners = (_determinant(slopes(points), xy) for points in (GAUSS, CORNERS))
    convex: BoolArray = np.asarray((at_corners * np.reshape(turned, (-1, 1)) > 0.0).all(axis=1))
    return np.where(convex[:, None], np.abs(at_points), 0.0)


def _determinant(D: Array, xy: Array) -> Array:
    """Of the derivatives of (x, y) by (xi, eta) at q points, (c, q)."""
    J = np.swapaxes(D, 1, 2)[None] @ xy[:, None]  # (c, q, 2, 2): [a, i] of x_i by xi_a
    return np.asarray(J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0])
