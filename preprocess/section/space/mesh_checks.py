"""Checks of the mesh of a section: errors for meshes that would give plausible but wrong
numbers."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from ....solver.errors import coded, few
from ....solver.math.arrays import Array
from ... import fenicsx
from ...mesh_input import coincident
from ..section_specification import SectionError
from .section_cells import CORNERS, KINDS, CellMesh, full_basis, renumbered

IntArray = NDArray[np.int64]
Warnings = list[dict[str, str]]

# Points where the map of a cell is checked: the integration points of curved cells.
QUADRATURE_DEGREE = 6
# Permutations of the nodes that reverse the orientation of clockwise cells, for each kind.
TURNED = ([0, 2, 1, 5, 4, 3, 6, 7, 8], [0, 3, 2, 1, 7, 6, 5, 4, 8])
COINCIDENT = 1e-7  # of the section's size: two nodes at the same place,
TOUCHING = 1e-2  # unless that is more than this part of the shortest edge at either of them
PAIRS = 2_000_000  # of cells and outer edges that are compared: 0.1 s
ROUNDING = 1e-12  # of the square of a cell's size: a smaller area counts as zero

# Sliver: smallest angle, largest change of area within a cell. Long rectangles are harmless, as
# those of thin walls and strips; small angles and folds are not, nor needles that are the section.
LEAST_SINE = 0.04
LEAST_AREA_RATIO = 0.02
LONGEST = 1e6  # ratio of sides, in cells longer than half of the section


def checked(mesh: CellMesh, where: str) -> tuple[CellMesh, Warnings]:
    """The mesh with all cells counter-clockwise, and warnings {"code", "message"} about it.

    Raises
    ------
    SectionError : folded cells, overlapping cells, or a section in several parts.
    """
    wrong = np.flatnonzero(~np.isfinite(mesh.points).all(axis=1))
    if wrong.size:
        raise SectionError(
            f"{where}: node {wrong[0] + 1} at {mesh.points[wrong[0]].tolist()}: expected finite "
            f"coordinates; wrong nodes: {wrong.size}"
        )
    mesh = _counter_clockwise(mesh, where)
    neighbours = _neighbours(mesh, where)
    _one_part(mesh, neighbours, where)
    return mesh, [*_unmerged(mesh), *_slivers(mesh), *_overlapping(mesh)]


def _at(place: Array) -> str:
    return f"({place[0]:.4g}, {place[1]:.4g})"


def _region(mesh: CellMesh, cell: int) -> str:
    return mesh.regions[mesh.region[cell]]


def _slopes(kind: int, shape: Array, points: Array) -> tuple[Array, Array]:
    """Tangents d x / d xi of cells, (c, q, 2, 2) as [..., x, xi], and their determinant."""
    slopes = full_basis(kind, points)[1]
    q, k, _ = slopes.shape
    table = np.swapaxes(slopes, 1, 2).reshape(2 * q, k) @ shape
    tangents = np.swapaxes(table.reshape(-1, q, 2, 2), 2, 3)
    return tangents, (
        tangents[..., 0, 0] * tangents[..., 1, 1] - tangents[..., 0, 1] * tangents[..., 1, 0]
    )


def _area_range(mesh: CellMesh) -> tuple[Array, Array, Array]:
    """Smallest and largest determinant of the map at the integration points of every cell, and the
    round-off of a zero determinant, (c,) each."""
    low, high, rounding = np.empty((3, mesh.n_cell))
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        points, _ = fenicsx.quadrature(KINDS[kind], QUADRATURE_DEGREE)
        area = _slopes(kind, shape, points)[1]
        side = np.ptp(shape, axis=1).max(axis=1)
        low[rows], high[rows], rounding[rows] = (
            area.min(axis=1),
            area.max(axis=1),
            ROUNDING * side**2,
        )
    return low, high, rounding


def _counter_clockwise(mesh: CellMesh, where: str) -> CellMesh:
    """Reverse cells that are numbered clockwise; their shape does not change.

    Error if the Jacobian of a cell changes its sign: the integrals would be wrong.
    """
    low, high, rounding = _area_range(mesh)
    flat = np.flatnonzero(np.maximum(-low, high) <= rounding)
    if flat.size:
        raise SectionError(
            f"{where}: {flat.size} of {len(low)} cells have no area, one at "
            f"{_at(mesh.middles[flat[0]])} in region {_region(mesh, flat[0])!r}"
        )
    folded = np.flatnonzero((low < -rounding) & (high > rounding))
    if folded.size:
        raise SectionError(
            f"{where}: {folded.size} of {len(low)} cells are folded, one at "
            f"{_at(mesh.middles[folded[0]])} in region {_region(mesh, folded[0])!r}: a middle "
            "node is too far from its edge, or the corners cross; refine there, or optimise "
            "the mesh (gmsh: Mesh.HighOrderOptimize = 2;)"
        )
    clockwise = low < -rounding
    return renumbered(mesh, clockwise, TURNED) if clockwise.any() else mesh


def _neighbours(mesh: CellMesh, where: str) -> sp.csr_matrix:
    """Adjacency of counter-clockwise cells by common edges, (c, c).

    Error if two cells have an edge with the same direction: they lie on the same side of it.
    """
    cells, first, second = mesh.edge_table
    n = len(mesh.points)
    forward, backward = first * n + second, second * n + first
    order = np.argsort(forward, kind="stable")
    same = np.flatnonzero(np.diff(forward[order]) == 0)
    if same.size:
        a, b = cells[order[same[0] : same[0] + 2]]
        names = sorted({_region(mesh, a), _region(mesh, b)})
        inside = (
            f"regions {names[0]!r} and {names[1]!r}" if len(names) > 1 else f"region {names[0]!r}"
        )
        raise SectionError(
            f"{where}: cells overlap at {_at(mesh.middles[a])}, in {inside}: a surface "
            "is in two physical groups, or is meshed twice, or a cell is inverted"
        )
    place = np.searchsorted(forward, backward, sorter=order)
    place = np.minimum(place, forward.size - 1)
    matching = forward[order[place]] == backward
    cell, other = cells[matching], cells[order[place[matching]]]
    c = mesh.n_cell
    return sp.csr_matrix((np.ones(cell.size, dtype=np.int8), (cell, other)), shape=(c, c))


def _one_part(mesh: CellMesh, neighbours: sp.csr_matrix, where: str) -> None:
    """Error for a section in several parts: it would be several beams."""
    n_part, part = connected_components(neighbours, directed=False)
    if n_part == 1:
        return
    parts = []
    for number in range(n_part):
        cells = np.flatnonzero(part == number)
        names = few(mesh.regions[i] for i in np.unique(mesh.region[cells]))
        owner, first, _ = mesh.edge_table
        x = mesh.points[first[np.isin(owner, cells)]]
        parts.append(f"{names} from {_at(x.min(axis=0))} to {_at(x.max(axis=0))}")
    listed = few(parts, "; ")
    nodes = [_used(mesh.nodes[part == number]) for number in range(n_part)]
    owners = np.bincount(np.concatenate(nodes), minlength=len(mesh.points))
    pairs = _coincident(mesh, _used(mesh.nodes))
    if np.any(owners > 1):
        place = _at(mesh.points[np.flatnonzero(owners > 1)[0]])
        reason = (
            f"they touch in single nodes, as at {place}, which is a hinge: they must share edges"
        )
    elif pairs.size:
        reason = (
            f"{len(pairs)} pairs of nodes have the same position, as at "
            f"{_at(mesh.points[pairs[0, 0]])}, but are not merged: merge them, so that the parts "
            "share edges (gmsh: Coherence; in the script, Coherence Mesh; for a mesh)"
        )
    else:
        reason = (
            "where they touch, their nodes must be the same (gmsh: BooleanFragments, or common "
            "curves of the surfaces)"
        )
    raise SectionError(
        f"{where}: the section is in {n_part} parts without a common edge: {listed}; {reason}"
    )


def _used(nodes: IntArray) -> IntArray:
    used = np.unique(nodes)
    return used[used >= 0]


def _coincident(mesh: CellMesh, nodes: IntArray) -> IntArray:
    """Pairs of nodes at the same position, (p, 2)."""
    near = COINCIDENT * float(np.ptp(mesh.points, axis=0).max())
    pairs = np.asarray(nodes[coincident(mesh.points[nodes], near)])
    if not pairs.size:
        return pairs
    _, first, second = mesh.edge_table
    shortest = np.full(len(mesh.points), np.inf)
    lengths = np.linalg.norm(mesh.points[second] - mesh.points[first], axis=1)
    np.minimum.at(shortest, first, lengths)
    np.minimum.at(shortest, second, lengths)
    apart = np.linalg.norm(mesh.points[pairs[:, 0]] - mesh.points[pairs[:, 1]], axis=1)
    shortest[np.isinf(shortest)] = 0.0  # nodes in the middle of an edge follow its ends
    return pairs[apart <= TOUCHING * shortest[pairs].min(axis=1)]


def _unmerged(mesh: CellMesh) -> Warnings:
    """Warning about a slit between adjacent cells, which is rarely intended."""
    _, first, second = mesh.edge_table
    low, high = np.minimum(first, second), np.maximum(first, second)
    key, count = np.unique(low * len(mesh.points) + high, return_counts=True)
    pairs = _coincident(mesh, np.unique(np.divmod(key[count == 1], len(mesh.points))))
    if not pairs.size:
        return []
    return coded(
        "unmerged-nodes",
        f"{len(pairs)} pairs of nodes have the same position, as at "
        f"{_at(mesh.points[pairs[0, 0]])}, but are not merged: the section has a slit there; "
        "merge them if it is not intended (gmsh: Coherence; or Coherence Mesh;)",
    )


def _overlapping(mesh: CellMesh) -> Warnings:
    """Warning about cells over others, as of two skins at a trailing edge that share no nodes.

    The outer edges wind twice around the middle of such a cell. Of large meshes some are tried.
    """
    _, first, second = mesh.edge_table
    n = len(mesh.points)
    outer = ~np.isin(first * n + second, second * n + first)
    a, b = mesh.points[first[outer]], mesh.points[second[outer]]
    rows = np.arange(0, mesh.n_cell, 1 + mesh.n_cell * len(a) // PAIRS)
    x, y = mesh.middles[rows].T[..., None]
    left = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])
    up = (a[:, 1] <= y) & (b[:, 1] > y) & (left > 0.0)
    down = (a[:, 1] > y) & (b[:, 1] <= y) & (left < 0.0)
    over = rows[up.sum(axis=1) - down.sum(axis=1) > 1]
    if not over.size:
        return []
    return coded(
        "cells-overlap",
        f"{len(over)} of {len(rows)} cells lie over others, one at {_at(mesh.middles[over[0]])} in "
        f"region {_region(mesh, over[0])!r}: stiffness and mass count twice there; cut the parts "
        "where they meet (gmsh: BooleanFragments)",
    )


def _slivers(mesh: CellMesh) -> Warnings:
    """Warning about cells of poor shape."""
    sine, ratio, least, side = np.empty((4, mesh.n_cell))
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        sine[rows], ratio[rows], least[rows], side[rows] = _quality(kind, shape)
    needle = (side > LONGEST * least) & (side > 0.5 * np.ptp(mesh.points, axis=0).max())
    bad = (sine < LEAST_SINE) | (ratio < LEAST_AREA_RATIO) | needle
    if not bad.any():
        return []
    worst = int(np.argmin(np.where(bad, np.minimum(sine, ratio), np.inf)))
    return coded(
        "sliver-elements",
        f"{np.count_nonzero(bad)} of {len(bad)} cells are slivers, the worst at "
        f"{_at(mesh.middles[worst])} in region {_region(mesh, worst)!r}: sine of the "
        f"smallest angle {sine[worst]:.2g} (expected {LEAST_SINE} at least), smallest to "
        f"largest area scale {ratio[worst]:.2g} ({LEAST_AREA_RATIO}); stresses there are poor",
    )


def _quality(kind: int, shape: Array) -> tuple[Array, Array, Array, Array]:
    """Sine of the smallest angle, smallest to largest area scale, shortest and longest side."""
    corners = fenicsx.NODES[KINDS[kind]][: CORNERS[kind]] / 2.0
    tangents, area = _slopes(kind, shape, corners)
    ends = shape[:, : CORNERS[kind]]
    sides = np.linalg.norm(ends - np.roll(ends, -1, axis=1), axis=2)
    sides.sort(axis=1)
    if KINDS[kind] == "triangle":
        # of the smallest angle, between the two longest sides
        (a2, a3), (b2, b3) = (ends[:, 1] - ends[:, 0]).T, (ends[:, 2] - ends[:, 0]).T
        sine = np.abs(a2 * b3 - a3 * b2) / (sides[:, 1] * sides[:, 2])
    else:
        lengths = np.linalg.norm(tangents, axis=2)  # of both tangents at each corner
        product = lengths[..., 0] * lengths[..., 1]
        sine = np.min(area / np.maximum(product, np.finfo(float).tiny), axis=1)
    return sine, area.min(axis=1) / area.max(axis=1), sides[:, 0], sides[:, -1]
