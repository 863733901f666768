"""Outline of a cross-section from the integration points of its recovery data.

A package has no mesh of its sections, but the integration points of every cell, which determine its
corners: four points of a quadrilateral by the bilinear map through them, those of a triangle by its
area. Edges that one cell has are the outline.
"""

from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray, distinct
from ..package.common.recovery_schema import SectionRecovery

SAME = 0.1  # corners closer than this part of the shortest edge are one
SMALL = 1e-6  # shortest edge of a cell, over the size of the section
STRAIGHT = 2e-3  # points closer to the line of their neighbours, over the size, are left out
LONG = 72  # points of a loop at most


class Outline(NamedTuple):
    """Closed loops of a section, and triangles of its face."""

    points: Array  # (p, 2) x2, x3                              [m]
    loops: tuple[IntArray, ...]  # rows of points, in order; the first is not repeated
    face: IntArray  # (f, 3) rows of points


def section_outline(recovery: SectionRecovery) -> Outline | None:
    """Return the outline of a section; None if its points do not give closed loops."""
    corners, following = _corners(recovery)
    if len(corners) == 0:
        return None
    shortest = float(np.linalg.norm(corners - corners[following], axis=1).min())
    size = float(np.ptp(recovery.points, axis=0).max())
    if not shortest > SMALL * size:
        return None
    points, rows = _joined(corners, SAME * shortest)
    loops = _loops(rows, rows[following])
    if not loops:
        return None
    short = [_simplified(points, loop, STRAIGHT * size) for loop in loops]
    if any(len(loop) < 3 for loop in short):
        return None
    used, number = np.unique(np.concatenate(short), return_inverse=True)
    ends = np.cumsum([len(loop) for loop in short])[:-1]
    loops = [np.asarray(part) for part in np.split(number, ends)]
    places = np.concatenate([points[used], points])
    return Outline(places, tuple(loops), _fans(rows, following) + len(used))


def _corners(recovery: SectionRecovery) -> tuple[Array, IntArray]:
    """Return corners (n, 2) of all cells, counterclockwise, and the row of the following one.

    Nothing if a cell has fewer than three.
    """
    order = np.argsort(recovery.cell, kind="stable")
    _, counts = np.unique(recovery.cell, return_counts=True)
    points, weights = recovery.points[order], recovery.weights[order]
    if (counts == 4).all():
        corners = _of_four(points.reshape(-1, 4, 2)).reshape(-1, 2)
    else:
        ends = np.cumsum(counts)[:-1]
        parts = zip(np.split(points, ends), np.split(weights, ends), strict=True)
        cells = [_scaled(some, weight) for some, weight in parts]
        counts = np.array([len(cell) for cell in cells])
        if (counts < 3).any():
            return np.zeros((0, 2)), np.zeros(0, dtype=np.int64)
        corners = np.concatenate(cells)
    ends = np.cumsum(counts)
    following = np.arange(1, ends[-1] + 1)
    following[ends - 1] = ends - counts
    return corners, following


def _fans(rows: IntArray, following: IntArray) -> IntArray:
    """Triangles (f, 3) of all cells, from the first corner of each."""
    last = np.flatnonzero(following <= np.arange(len(following)))
    first = np.repeat(following[last], np.diff(last, prepend=-1))
    k = np.flatnonzero((np.arange(len(rows)) > first) & (following > first))
    return np.column_stack([rows[first[k]], rows[k], rows[following[k]]])


def _of_four(points: Array) -> Array:
    """Corners (c, 4, 2) of quadrilaterals from their 2x2 integration points (c, 4, 2)."""
    off = points - points.mean(axis=1, keepdims=True)
    turn = np.argsort(np.arctan2(off[..., 1], off[..., 0]), axis=1)
    p = np.take_along_axis(points, turn[..., None], axis=1)
    a, b = 0.5 * (1.0 + np.sqrt(3.0)), 0.5 * (1.0 - np.sqrt(3.0))
    near = np.roll(p, 1, axis=1) + np.roll(p, -1, axis=1)
    return np.asarray(a * a * p + a * b * near + b * b * np.roll(p, 2, axis=1))


def _scaled(points: Array, weights: Array) -> Array:
    """Corners of a cell: the hull of its points, enlarged to the area of the cell."""
    hull = _hull(points)
    if len(hull) < 3:
        return hull
    x, y = hull.T
    inside = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    middle = weights @ points / weights.sum()
    return np.asarray(middle + np.sqrt(weights.sum() / inside) * (hull - middle))


def _hull(points: Array) -> Array:
    """Corners of the convex hull, counterclockwise; none of points on a line."""
    from scipy.spatial import ConvexHull, QhullError  # 0.1 s: sections of triangles only

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return points[:0]


def _joined(corners: Array, near: float) -> tuple[Array, IntArray]:
    """Return common corners (p, 2), those nearer than `near`, and the row of each corner (n,)."""
    grid = np.round(corners / near).astype(np.int64)
    grid -= grid.min(axis=0) - 1
    wide = int(grid[:, 1].max()) + 2
    keys, first, number = np.unique(
        grid[:, 0] * wide + grid[:, 1], return_index=True, return_inverse=True
    )
    around = np.array([i * wide + j for i in (0, -1, 1) for j in (0, -1, 1) if i or j])
    # rounding may put the same place into a neighbouring cell of the grid
    beside = np.searchsorted(keys, keys[:, None] + around).clip(max=len(keys) - 1)
    beside[keys[beside] != keys[:, None] + around] = -1
    chosen = np.arange(len(keys))
    order = np.argsort(first)  # of the corners
    for k in order[(beside[order] >= 0).any(axis=1)].tolist():
        near_by = [n for n in beside[k].tolist() if n >= 0 and first[n] < first[k]]
        chosen[k] = next((n for n in near_by if chosen[n] == n), k)
    kept = order[chosen[order] == order]
    rows = np.empty(len(keys), dtype=np.int64)
    rows[kept] = np.arange(len(kept))
    return corners[first[kept]], rows[chosen][number]


def _loops(begin: IntArray, end: IntArray) -> list[IntArray]:
    """Return closed loops of the edges that one cell has, or nothing if they do not close."""
    many = int(max(begin.max(), end.max())) + 1
    edges = distinct((begin * many + end)[begin != end])
    outer = edges[~np.isin(edges % many * many + edges // many, edges, assume_unique=True)]
    after: dict[int, list[int]] = {}
    for a, b in zip((outer // many).tolist(), (outer % many).tolist(), strict=True):
        after.setdefault(a, []).append(b)
    loops = []
    while after:
        start = min(after)
        loop, here = [start], start
        while True:
            following = after.get(here)
            if not following:
                return []
            there = following.pop()
            if not following:
                del after[here]
            if there == start:
                break
            loop.append(there)
            here = there
        loops.append(np.array(loop))
    return loops


def _simplified(points: Array, loop: IntArray, tolerance: float) -> IntArray:
    """Leave out points on straight parts, and more until the loop has LONG at most."""
    while True:
        kept = loop[_needed(points[loop], tolerance)]
        if len(kept) <= LONG:
            return kept
        tolerance *= 1.5


def _needed(p: Array, tolerance: float) -> Array:
    """Rows of a closed line (n, 2) that keep it within a tolerance (Douglas and Peucker)."""
    start = int(np.argmax(np.linalg.norm(p - p.mean(axis=0), axis=1)))
    order = np.roll(np.arange(len(p)), -start)
    line = np.concatenate([p[order], p[order[:1]]])
    middle = int(np.argmax(np.linalg.norm(line - line[0], axis=1)))
    keep = {0, middle}
    spans = [(0, middle), (middle, len(line) - 1)]
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        along = line[b] - line[a]
        off = line[a + 1 : b] - line[a]
        distance = np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]) / np.linalg.norm(along)
        if distance.max() > tolerance:
            k = a + 1 + int(np.argmax(distance))
            keep.add(k)
            spans += [(a, k), (k, b)]
    return np.sort(order[np.array(sorted(keep))])
