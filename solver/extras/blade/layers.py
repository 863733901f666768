"""Cells of a station: layers of the shell, webs, the face of a flatback."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray

# Layers of the shell of a station: columns along the contour, rows through the wall.
#
# Layers that do not overlap share a row. Where two layers of a row meet, the thicker one is
# tapered to the thickness of the other over half the length of their difference. The slope is of
# its own material and reaches so far beyond its end that its area stays right; the other layer
# begins behind. Where a layer ends beside nothing, it is tapered to zero over a length of its
# thickness, half of it inside.

TOUCH = 2e-3  # gap of two layers over the whole arc, below which they meet
STEEP = 0.5  # length of a slope between two layers over their difference
THINNEST = 1e-6  # [m] thickness of what is not there


@dataclass(frozen=True)
class Band:
    """A layer at a station: from arc `start` to `end` [-], both in 0 to 1."""

    name: str
    material: str
    angle_deg: float
    thickness: float  # [m]
    start: float
    end: float


@dataclass(frozen=True)
class WebLayers:
    """A web at a station: where its middle meets the shell, and its layers from the nose on."""

    name: str
    start: float  # [-] arc on the suction side
    end: float
    layers: tuple[Band, ...]
    widths: tuple[tuple[float, ...], ...] = ()  # of the layers on the contour, of both sides [m]


def rows_of(bands: list[Band]) -> list[list[Band]]:
    """Rows from outside inwards; a band goes to the first row behind all bands that it overlaps."""
    rows: list[list[Band]] = []
    for band in bands:
        first = 1 + max((k for k, row in enumerate(rows) if _overlaps(band, row)), default=-1)
        if first == len(rows):
            rows.append([])
        rows[first].append(band)
    return [sorted(row, key=lambda band: band.start) for row in rows]


def _overlaps(band: Band, row: list[Band]) -> bool:
    return any(min(band.end, o.end) - max(band.start, o.start) > TOUCH for o in row)


def joined(row: list[Band], perimeter: float) -> list[Band]:
    """The same row with bands that nearly meet joined at the foot of the thicker one's slope."""
    bands = list(row)
    for k in range(len(bands) - 1):
        one, two = row[k], row[k + 1]
        if abs(two.start - one.end) <= TOUCH:
            # The area of the slope is that of the full thickness up to the end of the layer.
            thick = max(one.thickness, two.thickness)
            beyond = 0.5 * slope(one, two, perimeter) * (one.thickness - two.thickness) / thick
            at = 0.5 * (one.end + two.start) + beyond
            bands[k] = replace(bands[k], end=at)
            bands[k + 1] = replace(bands[k + 1], start=at)
    return bands


def slope(one: Band, two: Band, perimeter: float) -> float:
    """Length over which the thicker of two bands that meet is tapered to the other [-].

    Parameters
    ----------
    one : first band
    two : second band
    perimeter : length of the contour [m]
    """
    room = min(one.end - one.start, two.end - two.start)
    return min(STEEP * abs(one.thickness - two.thickness) / perimeter, 0.4 * room)


def _ends(row: list[Band], perimeter: float) -> list[tuple[Band, tuple[Array, Array]]]:
    """The bands of a joined row, and the points of their thickness: arcs and values [-], [m]."""
    bands = []
    for k, band in enumerate(row):
        half = taper(band, perimeter)
        arcs, values = [], []
        for end, sense, other in (
            (band.start, 1.0, row[k - 1] if k else None),
            (band.end, -1.0, row[k + 1] if k + 1 < len(row) else None),
        ):
            if other is not None and end in (other.start, other.end):
                low = min(band.thickness, other.thickness)
                length = slope(band, other, perimeter) if low < band.thickness else 0.0
                arcs += [end, end + sense * length]
                values += [low, band.thickness]
            elif 0.0 < end < 1.0:
                arcs += [end - sense * half, end + sense * half]
                values += [0.0, band.thickness]
            else:
                arcs += [end, end]
                values += [band.thickness, band.thickness]
        order = [0, 1, 3, 2]
        bands.append((band, (np.array(arcs)[order], np.array(values)[order])))
    return bands


def breaks(row: list[Band], perimeter: float) -> list[float]:
    """Arcs at which the thickness of a row changes its slope, or its material changes."""
    points = {float(arc) for _, (arcs, _) in _ends(row, perimeter) for arc in arcs}
    return sorted(arc for arc in points if 0.0 < arc < 1.0)


def taper(band: Band, perimeter: float) -> float:
    """Half of the length over which a free end is tapered [-]."""
    return min(0.5 * band.thickness / perimeter, 0.25 * (band.end - band.start))


def thickness(row: list[Band], arcs: Array, perimeter: float) -> Array:
    """Thickness of a row at arcs (n,) [m].

    Parameters
    ----------
    row : bands of one layer of the wall
    arcs : places on the contour (n,), 0 to 1
    perimeter : length of the contour [m]
    """
    total = np.zeros(len(arcs))
    shared = {band.end for band in row} & {band.start for band in row}
    for band, (points, values) in _ends(row, perimeter):
        own = np.interp(arcs, points, values, left=0.0, right=0.0)
        if band.end in shared:
            own[arcs == band.end] = 0.0  # the next band has this column
        total += own
    return total


def material_of(row: list[Band], arc: float) -> Band:
    """The band of a row at an arc, or the nearest one (within its taper)."""
    return min(row, key=lambda band: max(band.start - arc, arc - band.end, 0.0))


# Nodes and cells of a station.


@dataclass
class StationMesh:
    """Nodes and cells of a station.

    Attributes
    ----------
    nodes : [x2, x3] [m]
    cells : node numbers of triangles and quadrilaterals, counter-clockwise
    regions : name of the layer of each cell
    bands : the layers by name
    outer : edges of the outer surface of the shell
    directions : layer direction of regions that are not of the shell
    removed : share of the area of layers for which the contour has no room
    """

    nodes: list[tuple[float, float]] = field(default_factory=list)
    cells: list[tuple[int, ...]] = field(default_factory=list)
    regions: list[str] = field(default_factory=list)
    outer: list[tuple[int, int]] = field(default_factory=list)
    bands: dict[str, Band] = field(default_factory=dict)
    directions: dict[str, tuple[float, float]] = field(default_factory=dict)
    removed: float = 0.0

    def node(self, point: Array) -> int:
        """Add a node; its number."""
        self.nodes.append((float(point[0]), float(point[1])))
        return len(self.nodes) - 1

    def cell(self, corners: Sequence[int], band: Band) -> None:
        """Add a cell of three or four different corners, in any sense of rotation, of a layer.

        Raises
        ------
        InputError : the region of this name belongs to another layer.
        """
        if self.bands.setdefault(band.name, band) != band:
            raise InputError(
                f"structure.layers: {band.name!r} is also a region of the station; expected "
                "another name of the layer"
            )
        distinct = list(dict.fromkeys(corners))
        if len(distinct) < 3:
            return
        if enclosed(np.array([self.nodes[k] for k in distinct])) < 0.0:
            distinct.reverse()
        self.cells.append(tuple(distinct))
        self.regions.append(band.name)


def enclosed(corners: Array) -> float:
    """Twice the area of a polygon of corners (n, 2), negative if they are clockwise [m2]."""
    x, y = corners, np.roll(corners, -1, axis=0)
    return float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum())


# Webs of a station: their feet on the contour, and their cells.
#
# A foot is a group of columns between which the layers of a web begin. Its widths on the contour
# are chosen so that the layers have their thickness across the web: on the inner face of a thick
# curved wall, and where a web stands obliquely on it, the distances of columns are others than on
# the contour.

WIDEST = 3.0  # width on the contour over the thickness of a layer


def feet_of(web: WebLayers, perimeter: float, spacing: float = math.inf) -> Array:
    """Arcs of the boundaries of a web's layers: on the suction and the pressure side (2, n).

    Layers that are wide beside `spacing` [-] have columns between them, equally many on both sides.

    Parameters
    ----------
    web : layers of the web
    perimeter : length of the contour [m]
    spacing : length of the cells along the contour, of the perimeter
    """
    plain = tuple(layer.thickness for layer in web.layers)
    positions = []
    # From the leading edge to the trailing edge: arcs fall on the suction side.
    for middle, sense, widths in zip(
        (web.start, web.end), (-1.0, 1.0), web.widths or (plain, plain), strict=True
    ):
        steps = np.concatenate([[0.0], np.cumsum(widths)]) / perimeter
        positions.append(middle + sense * (steps - 0.5 * steps[-1]))
    feet = np.array(positions)
    counts = np.maximum(1, np.round(np.abs(np.diff(feet, axis=1)).max(axis=0) / spacing))
    at = np.concatenate([[0.0], np.cumsum(counts)])
    return np.array([np.interp(np.arange(at[-1] + 1.0), at, foot) for foot in feet])


def fitted(
    webs: list[WebLayers], arcs: Array, inner: Array, perimeter: float
) -> tuple[list[WebLayers], float]:
    """Return webs whose feet give the layers their thickness, and the largest relative change.

    Parameters
    ----------
    inner : (n, 2) places of the columns on the inner face of the wall [m]
    """
    adjusted, largest = [], 0.0
    for web in webs:
        feet = inner[_columns_of(web, arcs, perimeter)]  # (2, n, 2)
        run = feet[1].mean(axis=0) - feet[0].mean(axis=0)
        across = np.array([-run[1], run[0]]) / np.linalg.norm(run)
        has = np.abs(np.diff(feet, axis=1) @ across)
        wanted = np.array([layer.thickness for layer in web.layers])
        old = np.diff(feet_of(web, perimeter), axis=1) * perimeter
        new = np.abs(old) * wanted / np.maximum(has, wanted / WIDEST)
        new = np.minimum(new, WIDEST * wanted)
        largest = max(largest, float(np.abs(new / np.abs(old) - 1.0).max()))
        adjusted.append(replace(web, widths=(tuple(new[0].tolist()), tuple(new[1].tolist()))))
    return adjusted, largest


def _columns_of(web: WebLayers, arcs: Array, perimeter: float) -> IntArray:
    """Columns of the boundaries of a web's layers (2, n)."""
    return np.asarray(np.abs(arcs - feet_of(web, perimeter)[..., None]).argmin(axis=-1))


def foot_without_room(
    webs: list[WebLayers], perimeter: float, low: float, high: float
) -> str | None:
    """Tell of a foot that reaches past the ends of the contour or over another one.

    Parameters
    ----------
    webs : layers of the webs
    perimeter : length of the contour [m]
    low : first arc that they may cover
    high : last arc

    Returns
    -------
    str or None
        Its key and what was expected; None if all feet have room.
    """
    taken: list[tuple[float, float, str]] = []
    for web in webs:
        for foot in feet_of(web, perimeter):
            one, two = float(foot.min()), float(foot.max())
            key = f"structure.webs: {web.name}: its foot covers the arcs {one:.5f} to {two:.5f}"
            if one <= low or two >= high:
                return f"{key}; expected arcs from {low:.5f} to {high:.5f}"
            for start, end, other in taken:
                if one < end and two > start:
                    return f"{key}; expected none of those of {other}, {start:.5f} to {end:.5f}"
            taken.append((one, two, web.name))
    return None


def crossing(webs: list[WebLayers], nose: float) -> str | None:
    """Tell of a web with both ends on one side of the leading edge `nose`, or of two that cross."""
    spans = [(web.name, min(web.start, web.end), max(web.start, web.end)) for web in webs]
    for name, low, high in spans:
        if not low < nose < high:
            return (
                f"structure.webs: {name}: from the arc {low:.5f} to {high:.5f}; expected one on "
                f"each side of the leading edge, {nose:.5f}"
            )
    for (one, low, high), (two, first, last) in itertools.combinations(spans, 2):
        if (low - first) * (high - last) > 0.0:
            return f"structure.webs: {one} and {two} cross; expected webs side by side"
    return None


def level_under(web: WebLayers, t: Array, arcs: Array, perimeter: float) -> None:
    """Give the wall one thickness under each foot of a web, the mean of what it has there.

    Parameters
    ----------
    web : layers of the web
    t : thickness of each row of the wall (k, n) [m], changed
    arcs : places on the contour (n,), 0 to 1
    perimeter : length of the contour [m]
    """
    for foot in feet_of(web, perimeter):
        at = np.flatnonzero((arcs > foot.min() - 1e-9) & (arcs < foot.max() + 1e-9))
        width = arcs[at[-1]] - arcs[at[0]]
        t[:, at] = (np.trapezoid(t[:, at], arcs[at], axis=1) / width)[:, None]


def add_web(
    mesh: StationMesh,
    web: WebLayers,
    arcs: Array,
    inner: list[int],
    perimeter: float,
    size: float,
) -> None:
    """Add a strip between the two feet; `inner` are nodes, `size` the length of its cells [m].

    Parameters
    ----------
    mesh : mesh of the station, added to
    web : layers of the web
    arcs : places on the contour (n,), 0 to 1
    inner : nodes on the inside of the wall
    perimeter : length of the contour [m]
    size : length of the cells along the web [m]

    Raises
    ------
    InputError : the walls are so near to each other that its layers cross between them.
    """
    columns = _columns_of(web, arcs, perimeter)
    one, two = ([inner[k] for k in _every(side)] for side in columns)
    start, end = (np.array([mesh.nodes[k] for k in line]) for line in (one, two))
    legs = end - start
    sides = [np.diff(line, axis=0) for line in (start, end)]
    pairs = [np.stack([side, leg], 1) for side in sides for leg in (legs[:-1], legs[1:])]
    turns = np.linalg.det(pairs)
    if turns.min() < 0.0 < turns.max():
        raise InputError(
            f"structure.webs: {web.name}: from the arc {web.start:.5f} to {web.end:.5f}; expected "
            "arcs between which the walls leave room for its layers, whose cells cross here"
        )
    height = float(np.linalg.norm(legs, axis=1).min())
    count = max(4, round(height / size))
    grid = [one]
    for k in range(1, count):
        f = k / count
        grid.append([mesh.node(p) for p in (1.0 - f) * start + f * end])
    grid.append(two)
    run = end.mean(axis=0) - start.mean(axis=0)
    ends = np.abs(columns[0] - columns[0, 0])
    for band, first, last in zip(web.layers, ends[:-1], ends[1:], strict=True):
        for a in range(first, last):
            for lower, upper in itertools.pairwise(grid):
                corners = (lower[a], lower[a + 1], upper[a + 1], upper[a])
                mesh.cell(corners, band)
        mesh.directions[band.name] = (float(run[0]), float(run[1]))


def _every(columns: IntArray) -> range:
    """All columns from the first to the last, which may lie before it."""
    step = 1 if columns[-1] > columns[0] else -1
    return range(columns[0], columns[-1] + step, step)


# The face of a flatback: its contour is open between the two corners of the trailing edge.
#
# Arcs of layers begin and end in the middle of the face. A face that is high against its wall is so
# a part of the contour; both sides of a low one are joined as at a sharp edge.

HIGH = 5.0  # height of the face over the thickness of the wall from which it is a wall itself
POINTS = 12  # of each half of the face


def wall_of_edge(bands: Sequence[Band]) -> float:
    """Thickness of the thicker wall at the trailing edge [m]."""
    suction = sum(band.thickness for band in bands if band.start <= TOUCH)
    return max(suction, sum(band.thickness for band in bands if band.end >= 1.0 - TOUCH))


def with_face(points: Array, bands: Sequence[Band]) -> tuple[Array, list[float]]:
    """Return the contour (n, 2) of a flatback closed by its face, and the arcs of its corners.

    The contour of another section is returned as it is, without corners.
    """
    height = float(np.linalg.norm(points[0] - points[-1]))
    if height <= HIGH * wall_of_edge(bands):
        return points, []
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    corner = 0.5 * height / (length + height)
    middle = 0.5 * (points[0] + points[-1])
    f = np.linspace(0.0, 1.0, POINTS, endpoint=False)[:, None]
    around = np.vstack(
        [(1.0 - f) * middle + f * points[0], points, ((1.0 - f) * middle + f * points[-1])[::-1]]
    )
    return around, [corner, 1.0 - corner]
