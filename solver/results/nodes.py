"""Positions of drawn points from the coordinates of their body."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..math.rotations import rotation_matrices
from ..math.rows import ComputedRows, computed
from .schema import BodyGeometry

MANY = 16  # rigid bodies that are moved together
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

    starts = np.cumsum([0] + [len(nodes) for _, nodes, _ in bodies])
    rigid = [i for i, (_, _, shapes) in enumerate(bodies) if not len(shapes)]
    # Many rigid bodies together: each has few nodes. It takes more memory for each of them.
    rigid = rigid if len(rigid) > MANY else []
    single = sorted(set(range(len(bodies))) - set(rigid))
    sizes = [len(bodies[i][1]) for i in rigid]
    of_rigid = _joined([np.arange(starts[i], starts[i + 1]) for i in rigid], 0).astype(int)
    nodes_B = _joined([bodies[i][1] for i in rigid], 3)
    columns = np.array([bodies[i][0] for i in rigid], dtype=int)[:, None] + np.arange(7)

    def points(first: int, end: int) -> Array:
        some = q[first:end]
        found = np.empty((len(some), count, 3))
        for i in single:
            node_positions(some, *bodies[i], found[:, starts[i] : starts[i + 1]])
        if rigid:
            at = some[:, columns]
            A = rotation_matrices(at[..., 3:].reshape(-1, 4)).reshape(*at.shape[:2], 3, 3)
            turned = np.einsum("kiab,ib->kia", np.repeat(A, sizes, axis=1), nodes_B)
            found[:, of_rigid] = turned + np.repeat(at[..., :3], sizes, axis=1)
        return found

    return computed(q, (len(q), count, 3), points)


def _joined(parts: list[Array], width: int) -> Array:
    return np.concatenate(parts) if parts else np.zeros((0, width) if width else 0)


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
