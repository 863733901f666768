"""The face of a flatback: its contour is open between the two corners of the trailing edge.

Files give arcs from corner to corner. A face that is high against the wall becomes a wall of the
layers that run around the whole section; all others end at its corners.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...math.arrays import Array
from .wall import TOUCH, Band, WebLayers

HIGH = 3.0  # height of the face over the thickness of the wall from which it is a wall itself
POINTS = 12  # of each half of the face
MITRE = 2.0  # thicknesses of the skins from a corner within which no layer ends


class Closed(NamedTuple):
    """A contour from the middle of the face around the section, its layers, webs and corners."""

    points: Array
    bands: list[Band]
    webs: list[WebLayers]
    corners: list[float]  # arcs; none if the contour was closed, or its face is low


def with_face(points: Array, bands: Sequence[Band], webs: Sequence[WebLayers]) -> Closed:
    """Close the contour (n, 2) of a flatback by its face.

    Arcs of layers and webs are changed to those of the longer contour.
    """
    height = float(np.linalg.norm(points[0] - points[-1]))
    wall = max(
        sum(band.thickness for band in bands if band.start <= TOUCH),
        sum(band.thickness for band in bands if band.end >= 1.0 - TOUCH),
    )
    if height <= HIGH * wall:
        return Closed(points, list(bands), list(webs), [])
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())

    def new(arc: float) -> float:
        return (0.5 * height + arc * length) / (length + height)

    middle = 0.5 * (points[0] + points[-1])
    f = np.linspace(0.0, 1.0, POINTS, endpoint=False)[:, None]
    around = np.vstack(
        [(1.0 - f) * middle + f * points[0], points, ((1.0 - f) * middle + f * points[-1])[::-1]]
    )
    whole = [band.start <= TOUCH and band.end >= 1.0 - TOUCH for band in bands]
    skins = sum(band.thickness for band, is_whole in zip(bands, whole, strict=True) if is_whole)
    changed = []
    for band, is_whole in zip(bands, whole, strict=True):
        clear = (MITRE * skins + 0.5 * band.thickness) / length
        start, end = max(band.start, clear), min(band.end, 1.0 - clear)
        start, end = (0.0, 1.0) if is_whole else (new(start), new(end))
        changed.append(replace(band, start=start, end=end))
    moved = [replace(web, start=new(web.start), end=new(web.end)) for web in webs]
    return Closed(around, changed, moved, [new(0.0), new(1.0)])
