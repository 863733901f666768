"""Pairs of triangles as quadrilaterals, the best first; what finds no partner stays a triangle."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import NONE, corner_counts
from ...fenicsx import PlainMesh
from .edges import Edges
from .triangles import BoolArray

# Least sine of the angles of a quadrilateral that is better than any triangles; 1 is a rectangle.
# Below it, quadrilaterals are better than triangles with sharper angles (docs/shells-accuracy.md).
SQUARE = 0.6
ROUNDING = 1e-9
FOLD = 0.9  # least cosine between the normals of the two triangles


class Unpaired(NamedTuple):
    """Triangles that stay although a triangle beside them stays too, and why most of them do."""

    left: int
    of: int  # triangles before
    reason: str


def paired(plain: PlainMesh) -> tuple[PlainMesh, Unpaired]:
    """The mesh with pairs of neighbouring triangles of a region as quadrilaterals.

    A pair is refused if its angles are worse than `SQUARE` and no better than those of its two
    triangles. Sides on physical curves stay: stiffeners and links need them.

    Parameters
    ----------
    plain : triangles, or triangles and quadrilaterals, of degree 1
    """
    three = corner_counts(plain.cells) == 3
    triangles = plain.cells[:, :3]
    edges = Edges(plain.cells)
    ends, owner = edges.ends, edges.owner
    one, other = edges.shared.T
    both = three[owner[one]] & three[owner[other]]
    one, other = one[both], other[both]
    a, b = owner[one], owner[other]
    joined = (plain.region[a] == plain.region[b]) & (ends[one, 0] == ends[other, 1])
    curves = [rows for rows in plain.named.curves.values() if len(rows)] if plain.named else []
    if curves:
        joined &= ~np.isin(edges.number[one], edges.find(np.concatenate(curves)))
    opposite = [triangles[c].sum(axis=1) - ends[one].sum(axis=1) for c in (a, b)]
    quads = np.stack([ends[one, 0], opposite[1], ends[one, 1], opposite[0]], axis=1)
    quality, flat = _quality(plain.points, quads)
    halves = np.minimum(*(_least_sine(plain.points, triangles[c]) for c in (a, b)))
    shaped = quality > np.minimum(SQUARE, halves) + ROUNDING
    taken = np.zeros(len(plain.cells), dtype=bool)
    partner = np.full(len(plain.cells), NONE)
    for row in np.lexsort([np.arange(len(quality)), -np.round(quality, 9)]):
        if joined[row] and flat[row] and shaped[row] and not (taken[a[row]] or taken[b[row]]):
            taken[[a[row], b[row]]] = True
            partner[min(a[row], b[row])] = row
    kept = np.flatnonzero(~taken | (partner != NONE))
    cells = np.full((len(kept), 4), NONE)
    cells[:, : plain.cells.shape[1]] = plain.cells[kept]
    merged = partner[kept] != NONE
    cells[merged] = quads[partner[kept[merged]]]
    left = ~(taken[a] | taken[b])
    found = [
        (len(np.unique([a[rows], b[rows]])), reason)
        for rows, reason in (
            (left & joined & flat, "the angles of their pairs are no better than their own"),
            (left & joined & ~flat, "the surface is folded between them"),
            (left & ~joined, "they are of different regions, or a physical curve is between them"),
        )
    ]
    total = len(np.unique([a[left], b[left]]))
    mesh = replace(plain, cells=cells, cell="mixed", region=plain.region[kept])
    return mesh, Unpaired(total, int(three.sum()), max(found)[1])


def _least_sine(points: Array, cells: IntArray) -> Array:
    """Least sine of the angles of triangles, (c,)."""
    corners = points[cells]
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    size = np.linalg.norm(after, axis=2) * np.linalg.norm(before, axis=2)
    sine = np.linalg.norm(np.cross(after, before), axis=2) / np.where(size > 0.0, size, 1.0)
    return np.asarray(sine.min(axis=1))


def _quality(points: Array, quads: IntArray) -> tuple[Array, BoolArray]:
    """Least sine of the angles, and whether the triangles are in one surface, (s,)."""
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
    return sine.min(axis=1), cosine > FOLD
