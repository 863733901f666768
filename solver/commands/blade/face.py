"""The face of a flatback: its contour is open between the two corners of the trailing edge.

Arcs of layers begin and end in the middle of the face. A face that is high against its wall is so
a part of the contour; both sides of a low one are joined as at a sharp edge.
"""

from collections.abc import Sequence

import numpy as np

from ...math.arrays import Array
from .wall import TOUCH, Band

HIGH = 5.0  # height of the face over the thickness of the wall from which it is a wall itself
POINTS = 12  # of each half of the face


def with_face(points: Array, bands: Sequence[Band]) -> tuple[Array, list[float]]:
    """Return the contour (n, 2) of a flatback closed by its face, and the arcs of its corners.

    The contour of another section is returned as it is, without corners.
    """
    height = float(np.linalg.norm(points[0] - points[-1]))
    wall = max(
        sum(band.thickness for band in bands if band.start <= TOUCH),
        sum(band.thickness for band in bands if band.end >= 1.0 - TOUCH),
    )
    if height <= HIGH * wall:
        return points, []
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    corner = 0.5 * height / (length + height)
    middle = 0.5 * (points[0] + points[-1])
    f = np.linspace(0.0, 1.0, POINTS, endpoint=False)[:, None]
    around = np.vstack(
        [(1.0 - f) * middle + f * points[0], points, ((1.0 - f) * middle + f * points[-1])[::-1]]
    )
    return around, [corner, 1.0 - corner]
