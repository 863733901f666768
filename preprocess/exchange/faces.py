"""Weights of the nodes of a face or an edge by its area or length.

Each face of an element shares its area among its nodes as the diagonal of its mass matrix does:
all shares are positive, also those of the corners of a face with nodes on its sides.
"""

from itertools import pairwise

import numpy as np

from ...solver.errors import InputError
from ...solver.math.arrays import Array, IntArray
from .free_body import Cells

# VTK type -> faces, as nodes of the cell: corners, then nodes on the sides.
_TET = ((0, 1, 2, 4, 5, 6), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 2, 3, 6, 9, 7))
_HEX = (
    (0, 1, 2, 3, 8, 9, 10, 11),
    (4, 5, 6, 7, 12, 13, 14, 15),
    (0, 1, 5, 4, 8, 17, 12, 16),
    (1, 2, 6, 5, 9, 18, 13, 17),
    (2, 3, 7, 6, 10, 19, 14, 18),
    (3, 0, 4, 7, 11, 16, 15, 19),
)
_WEDGE = (
    (0, 1, 2, 6, 7, 8),
    (3, 4, 5, 9, 10, 11),
    (0, 1, 4, 3, 6, 13, 9, 12),
    (1, 2, 5, 4, 7, 14, 10, 13),
    (2, 0, 3, 5, 8, 12, 11, 14),
)
_TRIANGLE, _QUAD = ((0, 1, 3), (1, 2, 4), (2, 0, 5)), ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))


def _corners(faces: tuple[tuple[int, ...], ...]) -> tuple[tuple[int, ...], ...]:
    return tuple(face[: (len(face) + 1) // 2] for face in faces)


FACES: dict[int, tuple[tuple[int, ...], ...]] = {
    10: _corners(_TET),
    24: _TET,
    12: _corners(_HEX),
    25: _HEX,
    13: _corners(_WEDGE),
    26: _WEDGE,
    5: _corners(_TRIANGLE),
    22: _TRIANGLE,
    9: _corners(_QUAD),
    23: _QUAD,
}
# Number of nodes of a face or an edge -> share of each: corners, then sides.
SHARES = {
    2: (1 / 2, 1 / 2),
    3: (1 / 3, 1 / 3, 1 / 3),
    4: (1 / 4,) * 4,
    6: (3 / 57,) * 3 + (16 / 57,) * 3,
    8: (3 / 76,) * 4 + (16 / 76,) * 4,
}
EDGE = (1 / 6, 1 / 6, 4 / 6)


def area_weights(nodes: Array, cells: Cells, rows: IntArray, where: str) -> Array:
    """Share of each of the nodes `rows` in the area (length) of the faces (edges) on them, sum 1.

    Raises InputError if no face of a cell lies on the nodes.
    """
    place = {int(row): k for k, row in enumerate(rows)}
    weights = np.zeros(len(rows))
    for kind, cell in cells.each():
        for face in FACES.get(kind, ()):
            own = [place.get(int(cell[k]), -1) for k in face]
            if min(own) < 0:
                continue
            edge = kind in (22, 23)
            points = nodes[cell[list(face)]][: 2 if edge else len(face)]
            weights[own] += face_area(points) * np.array(EDGE if edge else SHARES[len(face)])
    if not weights.sum() > 0.0:
        raise InputError(
            f'{where}.weights = "area": no face of a cell lies on these {len(rows)} nodes; '
            'expected a whole face, or weights = "equal"'
        )
    return np.asarray(weights / weights.sum())


def face_area(points: Array) -> float:
    """Area of a face by its corners; length of an edge of two nodes."""
    if len(points) == 2:
        return float(np.linalg.norm(points[1] - points[0]))
    corners = points[: {3: 3, 4: 4, 6: 3, 8: 4}[len(points)]]
    area = np.zeros(3)
    for one, two in pairwise(corners[1:]):
        area += np.cross(one - corners[0], two - corners[0]) / 2.0
    return float(np.linalg.norm(area))
