"""Layers of the shell of a station: columns along the contour, rows through the wall.

Layers that do not overlap share a row. Where two layers of a row meet, the thicker one is tapered
to the thickness of the other over half the length of their difference. The slope is of its own
material and reaches so far beyond its end that its area stays right; the other layer begins behind.
Where a layer ends beside nothing, it is tapered to zero over a length of its thickness, half of it
inside.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...math.arrays import Array

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
    found = list(row)
    for k in range(len(found) - 1):
        one, two = row[k], row[k + 1]
        if abs(two.start - one.end) <= TOUCH:
            # The area of the slope is that of the full thickness up to the end of the layer.
            thick = max(one.thickness, two.thickness)
            beyond = 0.5 * slope(one, two, perimeter) * (one.thickness - two.thickness) / thick
            at = 0.5 * (one.end + two.start) + beyond
            found[k] = replace(found[k], end=at)
            found[k + 1] = replace(found[k + 1], start=at)
    return found


def slope(one: Band, two: Band, perimeter: float) -> float:
    """Length over which the thicker of two bands that meet is tapered to the other [-]."""
    room = min(one.end - one.start, two.end - two.start)
    return min(STEEP * abs(one.thickness - two.thickness) / perimeter, 0.4 * room)


def _ends(row: list[Band], perimeter: float) -> list[tuple[Band, tuple[Array, Array]]]:
    """The bands of a joined row, and the points of their thickness: arcs and values [-], [m]."""
    found = []
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
        found.append((band, (np.array(arcs)[order], np.array(values)[order])))
    return found


def breaks(row: list[Band], perimeter: float) -> list[float]:
    """Arcs at which the thickness of a row changes its slope, or its material changes."""
    points = {float(arc) for _, (arcs, _) in _ends(row, perimeter) for arc in arcs}
    return sorted(arc for arc in points if 0.0 < arc < 1.0)


def taper(band: Band, perimeter: float) -> float:
    """Half of the length over which a free end is tapered [-]."""
    return min(0.5 * band.thickness / perimeter, 0.25 * (band.end - band.start))


def thickness(row: list[Band], arcs: Array, perimeter: float) -> Array:
    """Thickness of a row at arcs (n,) [m]."""
    found = np.zeros(len(arcs))
    shared = {band.end for band in row} & {band.start for band in row}
    for band, (points, values) in _ends(row, perimeter):
        own = np.interp(arcs, points, values, left=0.0, right=0.0)
        if band.end in shared:
            own[arcs == band.end] = 0.0  # the next band has this column
        found += own
    return found


def material_of(row: list[Band], arc: float) -> Band:
    """The band of a row at an arc, or the nearest one (within its taper)."""
    return min(row, key=lambda band: max(band.start - arc, arc - band.end, 0.0))
