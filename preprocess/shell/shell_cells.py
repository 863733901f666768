"""Triangles and quadrilaterals of a shell: mesh, edges, and geometry in axes of the laminate.

Sides run around a cell, from corner k to the next. Warped quadrilaterals are those
of their mean plane. The formulas of the elements do not depend on the direction of the
corners about e3, so a region may reverse its normals."""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.cells import NONE, area_vectors, centres, corner_counts, sides

DOFS = 6  # of a node: ux uy uz rx ry rz


class ShellError(Exception):
    """The description of a shell is wrong, or the shell cannot be analysed."""


class CellError(ShellError):
    """Cells that cannot be elements.

    Attributes
    ----------
    kind : "triangles" or "quadrilaterals"
    fault : what is wrong with each
    rows : (k,) the wrong ones
    """

    def __init__(self, message: str, kind: str, fault: str, rows: IntArray) -> None:
        super().__init__(message)
        self.kind, self.fault, self.rows = kind, fault, rows


class Edges:
    """Edges in ascending order of their nodes.

    Attributes
    ----------
    ends, owner : (s, 2), (s,) sides of all cells, cell after cell, and their cells
    number : (s,) edge of each side
    nodes : (e, 2) of each edge, ascending
    count : (e,) number of its cells
    """

    def __init__(self, cells: IntArray) -> None:
        self.ends, self.owner = sides(cells)
        self._step = int(cells.max(initial=0)) + 1
        self._keys, number = np.unique(self._key(self.ends), return_inverse=True)
        self.number: IntArray = number.ravel()
        self.nodes: IntArray = np.stack(np.divmod(self._keys, self._step), axis=1)
        self.count: IntArray = np.bincount(self.number, minlength=len(self._keys))

    @cached_property
    def shared(self) -> IntArray:
        """The sides of each edge of exactly two cells, (k, 2)."""
        order = np.argsort(self.number, kind="stable")
        first = np.cumsum(self.count) - self.count
        return np.asarray(order[first[self.count == 2][:, None] + np.arange(2)])

    def find(self, ends: IntArray) -> IntArray:
        """Edges with these nodes (k, 2) in any order, (k,); -1 where there is none."""
        key = self._key(ends)
        row = np.searchsorted(self._keys, key).clip(max=len(self._keys) - 1)
        return np.where(self._keys[row] == key, row, -1)

    def on(self, lines: IntArray) -> tuple[IntArray, IntArray]:
        """Pairs of a line of some nodes (l, 2), by its row, and a side of a cell there."""
        line = np.full(len(self._keys) + 1, -1)
        line[self.find(lines)] = np.arange(len(lines))
        line[-1] = -1
        row = line[self.number]
        sides = np.flatnonzero(row >= 0)
        return row[sides], sides

    def sums(self, values: Array) -> Array:
        """Sums over the sides of each edge of values (s, ...), (e, ...)."""
        out = np.zeros((len(self._keys), *values.shape[1:]))
        np.add.at(out, self.number, values)
        return out

    def _key(self, ends: IntArray) -> IntArray:
        return np.asarray(np.sort(ends, axis=1) @ [self._step, 1])


class Unpaired(NamedTuple):
    """Triangles that stay although a triangle beside them stays too, and why most of them do."""

    left: int
    of: int  # triangles before
    reason: str


NOTHING_LEFT = Unpaired(0, 0, "")


@dataclass(frozen=True, eq=False)  # equal only to itself
class ShellMesh:
    """A surface mesh of `n` nodes and `c` cells.

    The corners of a cell have the order of the mesh file, so its normal has the direction
    of the file.
    """

    points_G: Array  # (n, 3)                               [m]
    cells: IntArray  # (c, 3), or (c, 4) with quadrilaterals; triangles have NONE as fourth corner
    region: IntArray  # (c,) row of regions
    regions: tuple[str, ...]
    curves: dict[str, IntArray]  # physical curve -> (s, 2) nodes
    marks: dict[str, IntArray]  # physical point -> (k,) nodes
    node_tags: IntArray  # (n,) number of each node in gmsh
    unpaired: Unpaired = NOTHING_LEFT  # by element = "quadrilateral", before `refine`

    @property
    def n_node(self) -> int:
        """Number of nodes."""
        return len(self.points_G)

    @property
    def size(self) -> float:
        """Diagonal of the box around the mesh [m]."""
        return float(np.linalg.norm(np.ptp(self.points_G, axis=0)))

    @cached_property
    def edges(self) -> Edges:
        """Edges of the cells."""
        return Edges(self.cells)

    @property
    def area_vectors_G(self) -> Array:
        """Area of each cell times its normal, (c, 3) [m2]."""
        return area_vectors(self.points_G, self.cells)

    @property
    def centres_G(self) -> Array:
        """Mean of the corners of each cell, (c, 3) [m]."""
        return centres(self.points_G, self.cells)


# Integration points in area coordinates, weight area / 3 each: exact up to degree 2.
POINTS = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)

BoolArray = NDArray[np.bool_]
FLAT = 1e-10  # relative to the longest side squared: a smaller area counts as zero
STEEP = 1e-6  # sine of the smallest angle between a reference direction and a normal
NAMED = 5  # cells named in a message
NORMAL = "is normal to its reference direction"


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


def _refuse(wrong: BoolArray, fault: str, cells: IntArray) -> None:
    """Raise `CellError` with the first wrong cells, if any."""
    if not wrong.any():
        return
    faulty = np.flatnonzero(wrong)
    listed = ", ".join(f"{i} (nodes {', '.join(map(str, cells[i]))})" for i in faulty[:NAMED])
    more = f" and {len(faulty) - NAMED} more" if len(faulty) > NAMED else ""
    kind = "triangles" if cells.shape[1] == 3 else "quadrilaterals"
    raise CellError(f"each of these {kind} {fault}: {listed}{more}", kind, fault, faulty)


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
class CellGeometry:
    """Some cells with k corners, c of them; quadrilaterals are projected on their mean planes.

    Attributes
    ----------
    xy_E : (c, k, 2) corners from the centroid of the area [m]
    height : (c, k) of the corners above the mean plane, along e3 [m]; 0 of triangles
    A_GE : (c, 3, 3) rotation, v_G = A_GE v_E
    area : (c,) [m2]
    length : (c, k) of the sides [m]
    tangent : (c, k, 2) unit vectors along the sides, in E
    weight : (c, k) area of each point, of `POINTS` or of `GAUSS` [m2]
    width_ratio : (c, k) length over width, squared, of each side (`width_ratios`)
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

    def __getitem__(self, some: slice | IntArray) -> "CellGeometry":
        """Some of the cells."""
        return CellGeometry(*(getattr(self, one.name)[some] for one in fields(self)))

    @property
    def interpolation(self) -> Array:
        """Functions of the corners at the integration points, (k, k)."""
        return POINTS if self.xy_E.shape[1] == 3 else AT_GAUSS

    @property
    def corners_G(self) -> Array:
        """Corners from the centroid of the area in the mean plane, in G, (c, k, 3) [m]."""
        local = np.concatenate([self.xy_E, self.height[..., None]], axis=2)
        return np.asarray(local @ np.swapaxes(self.A_GE, 1, 2))


def cell_geometry(
    points_G: Array,
    cells: IntArray,
    direction_G: Array,
    flip: Array | bool = False,
    width_ratio: Array | float = 0.0,
) -> CellGeometry:
    """Geometry of triangles or quadrilaterals given by their corners.

    Parameters
    ----------
    points_G : (n, 3) nodes [m]
    cells : (c, 3 or 4) nodes of each cell; their order gives the normal, right-handed
    direction_G : (3,) or (c, 3) reference direction; its projection onto a cell is e1
    flip : bool or (c,), True where the normal e3 is reversed
    width_ratio : see `CellGeometry`

    Raises
    ------
    ShellError
        for a cell without area, or with the reference direction as its normal; for a quadrilateral
        with an angle of 180 degrees or more, or with crossed sides
    """
    cells, flip = np.asarray(cells), np.asarray(flip)
    corners = np.asarray(points_G, dtype=float)[cells]
    k = cells.shape[1]
    # the diagonals; of a triangle two sides
    across = corners[:, k - 2] - corners[:, 0], corners[:, k - 1] - corners[:, 1]
    normal = np.cross(*across)
    twice_area = np.linalg.norm(normal, axis=1)
    longest = np.max([np.linalg.norm(one, axis=1) for one in across], axis=0, initial=0.0)
    # "not greater" catches NaN as well
    _refuse(~(twice_area > FLAT * longest**2), "has no area", cells)
    e3 = normal / twice_area[:, None]
    A_GE, along = projected_axes(np.where(flip[..., None], -e3, e3), direction_G)
    _refuse(~along, NORMAL, cells)
    local = (corners - corners.mean(axis=1, keepdims=True)) @ A_GE
    xy, height = local[:, :, :2], np.ascontiguousarray(local[:, :, 2])
    if k == 3:
        area, height = 0.5 * twice_area, np.zeros_like(height)
        weight = np.repeat(area / 3.0, 3).reshape(-1, 3)
    else:
        # Determinants (c, q) of the derivatives of (x, y) by (xi, eta) at q points.
        by_place = (np.swapaxes(slopes(points), 1, 2)[None] for points in (GAUSS, CORNERS))
        weight, at_corners = (np.linalg.det(D @ xy[:, None]) for D in by_place)
        turned = np.where(flip, -1.0, 1.0)  # sense of the corners about e3
        convex = (at_corners * np.reshape(turned, (-1, 1)) > 0.0).all(axis=1)
        weight = np.abs(weight)
        convex &= (weight > 0.0).all(axis=1)
        _refuse(~convex, "has an angle of 180 degrees or more", cells)
        area = weight.sum(axis=1)
        xy = xy - ((weight @ AT_GAUSS)[:, None] @ xy) / area[:, None, None]
    edge = np.roll(xy, -1, axis=1) - xy
    length = np.linalg.norm(edge, axis=2)
    ratio = np.broadcast_to(np.asarray(width_ratio, dtype=float), length.shape)
    return CellGeometry(xy, height, A_GE, area, length, edge / length[..., None], weight, ratio)
