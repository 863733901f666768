"""Positions of drawn points from the coordinates of their body."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..math.rotations import rotation_matrices
from ..math.rows import ComputedRows, computed
from .schema import BodyGeometry

MOST_STORED = 100_000_000  # bytes of positions that a result file has in any case


def node_positions(
    q: Array, first: int, nodes_B: Array, shapes_B: Array, out: Array | None = None
) -> Array:
    """Return global positions (k, n, 3) of nodes. Paper: Eq. (15).

    First order in the modes, also for a stiffened body; for pictures.

    Parameters
    ----------
    q : (k, n_pos) coordinates of the mechanism
    first : column of the body's r_G (3), Euler parameters (4), then modal coordinates (m)
    nodes_B : (n, 3) rest positions [m]
    shapes_B : (m, n, 3) translations per unit mode [m]
    out : (k, n, 3) to fill; None: a new array
    """
    found = np.empty((len(q), len(nodes_B), 3)) if out is None else out
    # Time is the last axis until the end: long rows for NumPy, whatever the number of nodes.
    modal = np.ascontiguousarray(q[:, first + 7 : first + 7 + len(shapes_B)].T)
    x, y, z = (nodes_B[:, a, None] + shapes_B[:, :, a].T @ modal for a in range(3))
    A = np.ascontiguousarray(rotation_matrices(q[:, first + 3 : first + 7]).transpose(1, 2, 0))
    for a, (along_x, along_y, along_z) in enumerate(A):
        place = along_x * x
        place += along_y * y
        place += along_z * z
        place += q[:, first + a]
        found[:, :, a] = place.T
    return found


Moved = tuple[int, Array, Array]  # first, nodes_B, shapes_B of a body, as above


def all_positions(q: Any, bodies: Sequence[Moved]) -> Any:
    """Return the positions (k, n, 3) of all bodies end to end, computed when read if q is long."""

    count = sum(len(nodes) for _, nodes, _ in bodies)

    def points(first: int, end: int) -> Array:
        some, at = q[first:end], 0
        found = np.empty((len(some), count, 3))
        for body in bodies:
            _, nodes, _ = body
            node_positions(some, *body, found[:, at : at + len(nodes)])
            at += len(nodes)
        return found

    return computed(q, (len(q), count, 3), points)


def drawn_by_views(bodies: Sequence[BodyGeometry]) -> bool:
    """Tell whether positions follow from the coordinates: all bodies have views."""
    return bool(bodies) and all(body.view is not None for body in bodies)


def positions_of_views(q: Array, bodies: Sequence[BodyGeometry]) -> ComputedRows:
    """Return the positions (k, n, 3) of bodies with views, computed when they are read."""
    moved = [
        (body.view.first_position, body.nodes_B, body.view.shapes_B[:, :, :3])
        for body in bodies
        if body.view is not None
    ]
    count = sum(len(body.nodes_B) for body in bodies)
    return ComputedRows((len(q), count, 3), lambda a, b: np.asarray(all_positions(q[a:b], moved)))
