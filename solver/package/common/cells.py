"""Nodes of beams along their length, faces of cells, tables of triangles and quadrilaterals.

In a table of four columns a triangle has `NONE` as its fourth node.
"""

from itertools import pairwise

import numpy as np

from ...math.arrays import Array, IntArray


def node_positions(length: float, elements: int, stops: list[float]) -> Array:
    """Divide a beam into elements with a node at every stop.

    Parameters
    ----------
    length : length of the beam [m]
    elements : total number of elements
    stops : fractions of the length (0 to 1) that need a node

    Returns
    -------
    (elements + 1,) positions [m]: uniform if the stops allow it, otherwise
    uniform between stops, with the elements distributed by length.

    Raises
    ------
    ValueError : fewer elements than stretches between stops.
    """
    inner = sorted({0.0, 1.0, *stops})
    cuts = [inner[0]] + [b for a, b in pairwise(inner) if b - a > 1e-9]
    cuts[-1] = 1.0
    stretches = np.diff(cuts)
    if elements < len(stretches):
        raise ValueError(
            f"expected at least {len(stretches)}, one between any two neighbouring interfaces"
        )
    # each additional element goes to the stretch with the longest elements
    counts = np.ones(len(stretches), dtype=int)
    for _ in range(elements - len(stretches)):
        counts[np.argmax(np.round(stretches / counts, 12))] += 1
    parts = [
        np.linspace(a, b, k, endpoint=False)
        for a, b, k in zip(cuts[:-1], cuts[1:], counts, strict=True)
    ]
    return length * np.append(np.concatenate(parts), 1.0)


NONE = -1
TRIANGLE, QUADRILATERAL = 5, 9  # VTK's numbers of the cells


def cell_table(connectivity: IntArray, offsets: IntArray, rows: IntArray | None = None) -> IntArray:
    """Table of cells of 3 or 4 corners; cell j owns connectivity[offsets[j]:offsets[j + 1]].

    Parameters
    ----------
    connectivity : nodes of all cells, end to end
    offsets : begin of each cell (c + 1,)
    rows : numbers of the cells; None: all
    """
    rows = np.arange(len(offsets) - 1) if rows is None else rows
    first, count = offsets[rows], offsets[rows + 1] - offsets[rows]
    if (count == 3).all():
        return connectivity[first[:, None] + np.arange(3)]
    there = np.arange(4) < count[:, None]
    cells = np.full((len(count), 4), NONE)
    cells[there] = connectivity[(first[:, None] + np.arange(4))[there]]
    return cells


def corner_counts(cells: IntArray) -> IntArray:
    """3 or 4 for each cell, (c,)."""
    return np.asarray((cells != NONE).sum(axis=1))


def vtk_cells(cells: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Connectivity (i,), offsets (c + 1,) and VTK's types (c,) of the cells of a table."""
    count = corner_counts(cells)
    offsets = np.concatenate([[0], np.cumsum(count)])
    return cells[cells != NONE], offsets, np.where(count == 3, TRIANGLE, QUADRILATERAL)


def sides(cells: IntArray) -> tuple[IntArray, IntArray]:
    """Ends (s, 2) of the sides of all cells, cell after cell, and the cell of each, (s,)."""
    # The corner that follows each corner of a cell, in the form of the table.
    after = np.roll(cells, -1, axis=1)
    if cells.shape[1] == 4:
        short = cells[:, 3] == NONE
        after[short, 2], after[short, 3] = cells[short, 0], NONE
    ends = np.stack([cells, after], axis=2)
    there = cells != NONE
    return ends[there], np.nonzero(there)[0]


def centres(points_G: Array, cells: IntArray) -> Array:
    """Mean of the corners of each cell, (c, 3) [m]."""
    corners = points_G[cells]
    if cells.shape[1] == 3:
        return np.asarray(corners.mean(axis=1))
    there = (cells != NONE)[..., None]
    return np.asarray(np.where(there, corners, 0.0).sum(axis=1) / there.sum(axis=1))


def area_vectors(points_G: Array, cells: IntArray) -> Array:
    """Area of each cell times its normal, (c, 3) [m2]; half the product of the diagonals."""
    a, b, c = np.moveaxis(points_G[cells[:, :3]], 1, 0)
    if cells.shape[1] == 3:
        return np.asarray(0.5 * np.cross(b - a, c - a))
    last = np.where((cells[:, 3] == NONE)[:, None], a, points_G[cells[:, 3]])
    return np.asarray(0.5 * np.cross(c - a, last - b))


def corner_areas(points_G: Array, cells: IntArray) -> tuple[IntArray, Array]:
    """Corners of all cells and their shares of the areas, each (s,); the mean of 1 at a corner and
    0 at the others."""
    area = np.linalg.norm(area_vectors(points_G, cells), axis=1)
    if cells.shape[1] == 3:
        return cells.ravel(), np.repeat(area / 3.0, 3)
    there = cells != NONE
    shares = np.where(there, (area / 3.0)[:, None], 0.0)
    four = np.flatnonzero(there.all(axis=1))
    corners = points_G[cells[four]]
    # of a parallelogram a quarter; the slope of the Jacobian moves a twelfth of its difference
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    normal = area_vectors(points_G, cells[four]) / area[four, None]
    jacobian = 0.25 * np.einsum("cij,cj->ci", np.cross(after, before), normal)
    following, opposite = np.roll(jacobian, -1, axis=1), np.roll(jacobian, 2, axis=1)
    preceding = np.roll(jacobian, 1, axis=1)
    shares[four] = (4.0 * jacobian + 2.0 * (following + preceding) + opposite) / 9.0
    return cells[there], shares[there]


# Faces of VTK's cells, outward: corners, then the nodes on their sides.
_TETRA = ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (2, 0, 3, 6, 7, 9))
_HEXA = (
    (0, 3, 2, 1, 11, 10, 9, 8),
    (4, 5, 6, 7, 12, 13, 14, 15),
    (0, 1, 5, 4, 8, 17, 12, 16),
    (1, 2, 6, 5, 9, 18, 13, 17),
    (2, 3, 7, 6, 10, 19, 14, 18),
    (3, 0, 4, 7, 11, 16, 15, 19),
)
_WEDGE = (
    (0, 1, 2, 6, 7, 8),
    (3, 5, 4, 11, 10, 9),
    (0, 3, 4, 1, 12, 9, 13, 6),
    (1, 4, 5, 2, 13, 10, 14, 7),
    (2, 5, 3, 0, 14, 11, 12, 8),
)
_PYRAMID = (
    (0, 3, 2, 1, 8, 7, 6, 5),
    (0, 1, 4, 5, 10, 9),
    (1, 2, 4, 6, 11, 10),
    (2, 3, 4, 7, 12, 11),
    (3, 0, 4, 8, 9, 12),
)
SOLID_FACES = {24: _TETRA, 25: _HEXA, 29: _HEXA, 26: _WEDGE, 27: _PYRAMID}
LINEAR = {24: 10, 25: 12, 26: 13, 27: 14}  # the same cells without nodes on their sides


def corners_of(face: tuple[int, ...]) -> tuple[int, ...]:
    """Return the corners of a face with nodes on its sides."""
    return face[: (len(face) + 1) // 2]


SOLID_FACES |= {LINEAR[k]: tuple(map(corners_of, SOLID_FACES[k])) for k in LINEAR}
