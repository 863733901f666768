"""Layers of the shell of a station: columns along the contour, rows through the wall.

Layers that do not overlap share a row. Between two layers of a row that meet, the thickness of
their common column is the mean of both. Where a layer ends beside nothing, it is tapered to zero
over a length of its thickness, half of it inside.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...math.arrays import Array

TOUCH = 2e-3  # gap of two layers over the whole arc, below which they meet
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


def joined(row: list[Band]) -> list[Band]:
    """The same row with the ends of bands that nearly meet at one place."""
    found = list(row)
    for k in range(len(found) - 1):
        one, two = found[k], found[k + 1]
        if abs(two.start - one.end) <= TOUCH:
            at = 0.5 * (one.end + two.start)
            found[k] = Band(one.name, one.material, one.angle_deg, one.thickness, one.start, at)
            found[k + 1] = Band(two.name, two.material, two.angle_deg, two.thickness, at, two.end)
    return found


def _neighbours(row: list[Band]) -> list[tuple[Band, bool, bool]]:
    """The bands of a row, and whether each one meets the band before and the band behind it."""
    meets = [one.end == two.start for one, two in pairwise(row)]
    return list(zip(row, [False, *meets], [*meets, False], strict=True))


def breaks(row: list[Band], perimeter: float) -> list[float]:
    """Arcs at which the thickness of a row changes its slope, or its material changes."""
    found = []
    for band, met, meets in _neighbours(row):
        half = taper(band, perimeter)
        found += [band.start] if met else [band.start - half, band.start + half]
        found += [band.end] if meets else [band.end - half, band.end + half]
    return [arc for arc in found if 0.0 < arc < 1.0]


def taper(band: Band, perimeter: float) -> float:
    """Half of the length over which a free end is tapered [-]."""
    return min(0.5 * band.thickness / perimeter, 0.25 * (band.end - band.start))


def thickness(row: list[Band], arcs: Array, perimeter: float) -> Array:
    """Thickness of a row at arcs (n,) [m]."""
    found = np.zeros(len(arcs))
    for band, met, meets in _neighbours(row):
        half = max(taper(band, perimeter), 1e-12)
        low, high = band.start, band.end
        rise = 1.0 if met or low <= 0.0 else np.clip((arcs - low + half) / (2.0 * half), 0.0, 1.0)
        fall = (
            1.0 if meets or high >= 1.0 else np.clip((high + half - arcs) / (2.0 * half), 0.0, 1.0)
        )
        inside = (arcs >= low - (0.0 if met else half)) & (arcs <= high + (0.0 if meets else half))
        share = np.where(inside, rise * fall, 0.0)
        at_joint = (met & np.isclose(arcs, low, atol=1e-12)) | (
            meets & np.isclose(arcs, high, atol=1e-12)
        )
        found += band.thickness * np.where(at_joint, 0.5, share)
    return found


def material_of(row: list[Band], arc: float) -> Band:
    """The band of a row at an arc, or the nearest one (within its taper)."""
    return min(row, key=lambda band: max(band.start - arc, arc - band.end, 0.0))
