"""Pairs of triangles as quadrilaterals, the best first; what finds no partner stays a triangle."""

from dataclasses import replace

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.shell.cells import NONE, sides
from ..fenicsx import PlainMesh

SQUARE = 0.6  # least sine of the angles of a quadrilateral; 1 is a rectangle
FOLD = 0.9  # least cosine between the normals of the two triangles


def paired(plain: PlainMesh) -> PlainMesh:
    """The mesh with pairs of neighbouring triangles of a region as quadrilaterals.

    Parameters
    ----------
    plain : triangles of degree 1
    """
    ends, owner = sides(plain.cells)
    key = np.sort(ends, axis=1) @ [len(plain.points), 1]
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) > 0]))
    count = np.diff(np.concatenate([first, [len(key)]]))
    one, other = order[first[count == 2]], order[first[count == 2] + 1]
    same = plain.region[owner[one]] == plain.region[owner[other]]
    same &= ends[one, 0] == ends[other, 1]  # the normals agree
    one, other = one[same], other[same]
    local = np.concatenate([np.arange(3)] * len(plain.cells))
    quads = _around(plain.cells, owner[one], local[one], owner[other], local[other])
    quality = _quality(plain.points, quads)
    taken = np.zeros(len(plain.cells), dtype=bool)
    partner = np.full(len(plain.cells), NONE)
    for row in np.lexsort([np.arange(len(quality)), -np.round(quality, 9)]):
        a, b = owner[one[row]], owner[other[row]]
        if quality[row] > SQUARE and not (taken[a] or taken[b]):
            taken[a] = taken[b] = True
            partner[min(a, b)] = row
    kept = np.flatnonzero(~taken | (partner != NONE))
    cells = np.pad(plain.cells[kept], ((0, 0), (0, 1)), constant_values=NONE)
    merged = partner[kept] != NONE
    cells[merged] = quads[partner[kept[merged]]]
    return replace(plain, cells=cells, cell="mixed", region=plain.region[kept])


def _around(
    cells: IntArray, a: IntArray, side_a: IntArray, b: IntArray, side_b: IntArray
) -> IntArray:
    """Corners around two triangles with a common side, in the sense of the first, (s, 4)."""
    opposite_a, opposite_b = cells[a, (side_a + 2) % 3], cells[b, (side_b + 2) % 3]
    start, end = cells[a, side_a], cells[a, (side_a + 1) % 3]
    return np.stack([start, opposite_b, end, opposite_a], axis=1)


def _quality(points: Array, quads: IntArray) -> Array:
    """Least sine of the angles, 0 for a fold, (s,)."""
    corners = points[quads]
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    turn = np.cross(after, before)
    size = np.linalg.norm(after, axis=2) * np.linalg.norm(before, axis=2)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sine = np.einsum("sci,si->sc", turn, normal) / size
    # the two triangles have the corners 1 2 3 and 3 4 1
    halves = turn[:, 1], turn[:, 3]
    cosine = np.einsum("si,si->s", *halves) / np.prod(
        [np.linalg.norm(half, axis=1) for half in halves], axis=0
    )
    return np.where(cosine > FOLD, sine.min(axis=1), 0.0)
