"""Surface of a rigid body for pictures: a box of its inertia, and bars to its places."""

import numpy as np

from ..math.arrays import Array
from .surfaces import Parts, add_bars
from .view import Surface

THICKER = 1.3  # a box than the bars, at least
LONGEST = 1.2  # edge of a box, over the reach of the mechanism
# Corners of a box by the signs of its half edges, and its faces, outward.
_SIGNS = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
_FACES = np.array(
    [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
)


def uniform_box(mass: float, S_B: Array, J_B: Array) -> tuple[Array, Array]:
    """Edges (3,) [m] and axes (3, 3), by columns, of a uniform box with this inertia.

    Parameters
    ----------
    S_B : (3,) first moment of mass about the origin [kg m]
    J_B : (3, 3) inertia about the origin [kg m2]

    Moments of inertia that no solid has give edges of length 0.
    """
    if not mass > 0.0:
        return np.zeros(3), np.eye(3)
    c = S_B / mass
    about_centre = J_B - mass * (c @ c * np.eye(3) - np.outer(c, c))
    moments, axes = np.linalg.eigh(0.5 * (about_centre + about_centre.T))
    with np.errstate(over="ignore"):  # of masses near the smallest number
        squares = 6.0 * (moments.sum() - 2.0 * moments) / mass
    return np.sqrt(np.clip(squares, 0.0, 1e300)), axes * np.sign(np.linalg.det(axes))


def rigid_surface(
    nodes_B: Array, centre_B: Array, edges: Array, axes_B: Array, width: float, reach: float
) -> Surface:
    """Return a box at the centre of mass, and bars from the first node to each of the others.

    Parameters
    ----------
    edges, axes_B : of the box
    width : of the bars [m]
    reach : size of the mechanism, which limits the box [m]
    """
    parts = Parts()
    edges = edges * min(1.0, LONGEST * reach / max(float(edges.max()), 1e-300))
    half = 0.5 * np.maximum(edges, THICKER * width)
    corners = centre_B - nodes_B[0] + (_SIGNS * half) @ axes_B.T
    first = parts.points(np.zeros(8, dtype=np.int64), corners)
    parts.quads(first + _FACES, np.full(_FACES.shape, -1))
    add_bars(parts, nodes_B, width)
    return parts.surface()
