"""Checks of the mesh of a section: errors for meshes that would give plausible but wrong
numbers."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ...solver.errors import few
from ...solver.math.arrays import Array
from .. import fenicsx
from ..fenicsx import PlainMesh
from .errors import SectionError

IntArray = NDArray[np.int64]
Warnings = list[dict[str, str]]

# Points where the map of a cell is checked: the integration points of curved cells.
QUADRATURE_DEGREE = 6
# Permutations that reverse the orientation of clockwise cells.
TURNED = {
    ("triangle", 1): [0, 2, 1],
    ("triangle", 2): [0, 2, 1, 5, 4, 3],
    ("quadrilateral", 1): [0, 3, 2, 1],
    ("quadrilateral", 2): [0, 3, 2, 1, 7, 6, 5, 4, 8],
}
COINCIDENT = 1e-7  # of the section's size: two nodes at the same place
ROUNDING = 1e-12  # of the square of a cell's size: a smaller area counts as zero

# Sliver: smallest angle, largest change of area within a cell, largest aspect ratio. The graded
# walls of the library are long rectangles. They are harmless; small angles and folds are not.
LEAST_SINE = 0.04
LEAST_AREA_RATIO = 0.02
LONGEST = 5000.0


def checked(plain: PlainMesh, where: str) -> tuple[PlainMesh, Warnings]:
    """The mesh with all cells counter-clockwise, and warnings {"code", "message"} about it.

    Raises
    ------
    SectionError : folded cells, overlapping cells, or a section in several parts.
    """
    plain = _counter_clockwise(plain, where)
    neighbours = _neighbours(plain, where)
    _one_part(plain, neighbours, where)
    return plain, [*_unmerged(plain), *_slivers(plain)]


def _at(place: Array) -> str:
    return f"({place[0]:.4g}, {place[1]:.4g})"


def _region(plain: PlainMesh, cell: int) -> str:
    return plain.regions[plain.region[cell]]


def _slopes(plain: PlainMesh, points: Array) -> tuple[Array, Array]:
    """Tangents d x / d xi of every cell, (c, q, 2, 2) as [..., x, xi], and their determinant."""
    _, slopes = fenicsx.basis(plain.cell, plain.degree, points)
    q, k, _ = slopes.shape
    nodes = plain.points[plain.dolfinx_cells]  # (c, k, 2)
    table = np.swapaxes(slopes, 1, 2).reshape(2 * q, k) @ nodes
    tangents = np.swapaxes(table.reshape(-1, q, 2, 2), 2, 3)
    return tangents, (
        tangents[..., 0, 0] * tangents[..., 1, 1] - tangents[..., 0, 1] * tangents[..., 1, 0]
    )


def _area_range(plain: PlainMesh) -> tuple[Array, Array, Array]:
    """Smallest and largest determinant of the map at the integration points of every cell, and the
    round-off of a zero determinant, (c,) each."""
    points, _ = fenicsx.quadrature(plain.cell, QUADRATURE_DEGREE)
    area = _slopes(plain, points)[1]
    side = np.ptp(plain.points[plain.corners], axis=1).max(axis=1)
    return area.min(axis=1), area.max(axis=1), ROUNDING * side**2


def folds(plain: PlainMesh) -> bool:
    """True if the Jacobian of a cell changes its sign within the cell."""
    low, high, rounding = _area_range(plain)
    return bool(np.any((low < -rounding) & (high > rounding)))


def _counter_clockwise(plain: PlainMesh, where: str) -> PlainMesh:
    """Reverse cells that are numbered clockwise; their shape does not change.

    Error if the Jacobian of a cell changes its sign: the integrals would be wrong.
    """
    low, high, rounding = _area_range(plain)
    flat = np.flatnonzero(np.maximum(-low, high) <= rounding)
    if flat.size:
        raise SectionError(
            f"{where}: {flat.size} of {len(low)} cells have no area, one at "
            f"{_at(plain.middles[flat[0]])} in region {_region(plain, flat[0])!r}"
        )
    folded = np.flatnonzero((low < -rounding) & (high > rounding))
    if folded.size:
        raise SectionError(
            f"{where}: {folded.size} of {len(low)} cells are folded, one at "
            f"{_at(plain.middles[folded[0]])} in region {_region(plain, folded[0])!r}: a middle "
            "node is too far from its edge, or the corners cross; refine there, or optimise "
            "the mesh (gmsh: Mesh.HighOrderOptimize = 2;)"
        )
    clockwise = low < -rounding
    if not clockwise.any():
        return plain
    turned = plain.cells[:, TURNED[plain.cell, plain.degree]]
    return replace(plain, cells=np.where(clockwise[:, None], turned, plain.cells))


def _neighbours(plain: PlainMesh, where: str) -> sp.csr_matrix:
    """Adjacency of counter-clockwise cells by common edges, (c, c).

    Error if two cells have an edge with the same direction: they lie on the same side of it.
    """
    edges = fenicsx.EDGES[plain.cell]
    ends = plain.corners[:, edges]  # (c, e, 2)
    n = len(plain.points)
    forward = (ends[..., 0] * n + ends[..., 1]).ravel()
    backward = (ends[..., 1] * n + ends[..., 0]).ravel()
    order = np.argsort(forward, kind="stable")
    same = np.flatnonzero(np.diff(forward[order]) == 0)
    if same.size:
        a, b = order[same[0] : same[0] + 2] // len(edges)
        names = sorted({_region(plain, a), _region(plain, b)})
        inside = (
            f"regions {names[0]!r} and {names[1]!r}" if len(names) > 1 else f"region {names[0]!r}"
        )
        raise SectionError(
            f"{where}: cells overlap at {_at(plain.middles[a])}, in {inside}: a surface "
            "is in two physical groups, or is meshed twice, or a cell is inverted"
        )
    place = np.searchsorted(forward, backward, sorter=order)
    place = np.minimum(place, forward.size - 1)
    found = forward[order[place]] == backward
    cell, other = np.flatnonzero(found) // len(edges), order[place[found]] // len(edges)
    c = len(plain.cells)
    return sp.csr_matrix((np.ones(cell.size, dtype=np.int8), (cell, other)), shape=(c, c))


def _one_part(plain: PlainMesh, neighbours: sp.csr_matrix, where: str) -> None:
    """Error for a section in several parts: it would be several beams."""
    n_part, part = connected_components(neighbours, directed=False)
    if n_part == 1:
        return
    parts = []
    for number in range(n_part):
        cells = np.flatnonzero(part == number)
        names = few(plain.regions[i] for i in np.unique(plain.region[cells]))
        x = plain.points[plain.corners[cells]].reshape(-1, 2)
        parts.append(f"{names} from {_at(x.min(axis=0))} to {_at(x.max(axis=0))}")
    listed = few(parts, "; ")
    nodes = [np.unique(plain.cells[part == number]) for number in range(n_part)]
    owners = np.bincount(np.concatenate(nodes), minlength=len(plain.points))
    pairs = _coincident(plain, np.arange(len(plain.points)))
    if np.any(owners > 1):
        place = _at(plain.points[np.flatnonzero(owners > 1)[0]])
        reason = (
            f"they touch in single nodes, as at {place}, which is a hinge: they must share edges"
        )
    elif pairs.size:
        reason = (
            f"{len(pairs)} pairs of nodes have the same position, as at "
            f"{_at(plain.points[pairs[0, 0]])}, but are not merged: merge them, so that the parts "
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


def _boundary_nodes(plain: PlainMesh) -> IntArray:
    """Ends of the edges that only one cell has."""
    ends, number = plain.edges()
    outer = np.bincount(number.ravel(), minlength=len(ends)) == 1
    return np.unique(ends[outer])


def _coincident(plain: PlainMesh, nodes: IntArray) -> IntArray:
    """Pairs of nodes at the same position, (p, 2)."""
    near = COINCIDENT * float(np.ptp(plain.points, axis=0).max())
    pairs = cKDTree(plain.points[nodes]).query_pairs(near, output_type="ndarray")
    return np.asarray(nodes[pairs])


def _unmerged(plain: PlainMesh) -> Warnings:
    """Warning about a slit between adjacent cells, which is rarely intended."""
    pairs = _coincident(plain, _boundary_nodes(plain))
    if not pairs.size:
        return []
    return [
        {
            "code": "unmerged-nodes",
            "message": f"{len(pairs)} pairs of nodes have the same position, as at "
            f"{_at(plain.points[pairs[0, 0]])}, but are not merged: the section has a slit there; "
            "merge them if it is not intended (gmsh: Coherence; or Coherence Mesh;)",
        }
    ]


def _slivers(plain: PlainMesh) -> Warnings:
    """Warning about cells of poor shape."""
    corners = fenicsx.NODES[plain.cell][: len(fenicsx.EDGES[plain.cell])] / 2.0
    tangents, area = _slopes(plain, corners)
    ends = plain.points[plain.corners]
    sides = np.linalg.norm(ends - np.roll(ends, -1, axis=1), axis=2)
    sides.sort(axis=1)
    if plain.cell == "triangle":
        # of the smallest angle, between the two longest sides
        (a2, a3), (b2, b3) = (ends[:, 1] - ends[:, 0]).T, (ends[:, 2] - ends[:, 0]).T
        sine = np.abs(a2 * b3 - a3 * b2) / (sides[:, 1] * sides[:, 2])
    else:
        lengths = np.linalg.norm(tangents, axis=2)  # of both tangents at each corner
        product = lengths[..., 0] * lengths[..., 1]
        sine = np.min(area / np.maximum(product, np.finfo(float).tiny), axis=1)
    ratio = area.min(axis=1) / area.max(axis=1)
    bad = (sine < LEAST_SINE) | (ratio < LEAST_AREA_RATIO) | (sides[:, -1] > LONGEST * sides[:, 0])
    if not bad.any():
        return []
    worst = int(np.argmin(np.where(bad, np.minimum(sine, ratio), np.inf)))
    return [
        {
            "code": "sliver-elements",
            "message": f"{np.count_nonzero(bad)} of {len(bad)} cells are slivers, the worst at "
            f"{_at(plain.middles[worst])} in region {_region(plain, worst)!r}: sine of the "
            f"smallest angle {sine[worst]:.2g} (expected {LEAST_SINE} at least), smallest to "
            f"largest area scale {ratio[worst]:.2g} ({LEAST_AREA_RATIO}); stresses there are poor",
        }
    ]
