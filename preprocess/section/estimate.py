"""Error estimate of K: by one degree more on the same mesh, at singular points, of curved edges.

Near a point where materials, edges and re-entrant corners meet, the displacement is
r^lambda phi(theta) (Williams 1952; Leguillon and Sanchez-Palencia 1987). The energy of the error of
a field of degree p in the cells around it falls with p^(-4 lambda) (Babuska and Suri 1987). lambda
is 0.54 at a corner of 270 deg, and tends to 0 where stiff and soft quarters meet crosswise.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.materials import rotated
from ..fenicsx import EDGES
from .recovery import Result, unit_strains
from .space.section_cells import CORNERS, KINDS, CellMesh

# The error of K falls with the degree of the field, at least with degree^-RATE. This is the rate
# for singular stresses at the edge of a ply or a re-entrant corner; smooth parts converge faster,
# stronger singularities, as between stiff and soft quarters, more slowly (`cell_exponents`).
# docs/sections-accuracy.md compares the estimates with true errors.
RATE = 2.1
REGULAR = RATE / 4.0  # exponent lambda of the displacement that has this rate


def singular_error(K: Array, energy: Array, exponents: Array, degree: int) -> Array:
    """What `error_estimate` lacks of the error near singular points, (6, 6), in units of K.

    Parameters
    ----------
    energy : (c, 6, 6) of the difference to one degree more, under pairs of unit resultants
    exponents : (c,) lambda of the strongest singularity at each cell, REGULAR at most
    """
    # flexibilities add up, stiffnesses do not: an error may be larger than the stiffness itself
    S, usual = np.linalg.inv(K), _removed(degree)
    # the parts of the degrees above p, j^(-4 lambda - 1), add up to (p + 1/2)^(-4 lambda)
    singular = 1.0 - ((degree + 0.5) / (degree + 1.5)) ** (4.0 * exponents)
    counted = energy.sum(axis=0) / usual
    share = np.where(exponents < REGULAR, singular, usual)
    whole = np.einsum("c,cij->ij", 1.0 / share, energy)
    return np.abs(np.linalg.inv(S + counted) - np.linalg.inv(S + whole))


def error_estimate(K: Array, K_richer: Array, degree: int) -> Array:
    """Expected |error| of each entry of K, (6, 6), in its units.

    With errors proportional to degree^-RATE, the difference of two degrees is a known fraction of
    the error of K.

    Parameters
    ----------
    K : (6, 6) by a field of some degree
    K_richer : (6, 6) by one degree more on the same mesh
    degree : of the field of K
    """
    return np.abs(K - K_richer) / _removed(degree)


def error_of_edges(mesh: CellMesh, modulus: Array) -> float:
    """Error of K, scaled by sqrt(K_ii K_jj), because curved edges are parabolas.

    An edge that goes on at its ends is compared with the curve of degree 4 or 6 through its nodes
    and those of the edges beyond, others with an arc. The cell inside the curve lacks the sliver
    between both, the one outside has it too much. Of the axial stiffness and its second moments
    about the origin, to which K refers, the one that changes most counts.

    Parameters
    ----------
    modulus : (c,) Young's modulus of the cells along the beam [Pa]
    """
    own, net = _curved_edges(mesh, modulus)
    if not net.size:
        return 0.0
    before, after = _continued(own)
    lost = np.zeros((len(net), 3))
    for back, on in ((False, False), (False, True), (True, False), (True, True)):
        rows = np.flatnonzero(((before >= 0) == back) & ((after >= 0) == on))
        points = own.points[rows]
        if back:
            points = np.concatenate([own.beyond(before[rows])[:, ::-1], points], axis=1)
        if on:
            points = np.concatenate([points, own.beyond(after[rows])], axis=1)
        if back or on:
            first = 2 if back else 0
            lost[rows] = _moments(points, first) - _moments(own.points[rows], 0)
        else:
            lost[rows] = _slivers_of_arcs(points)
    weight, places = np.zeros(mesh.n_cell), mesh.middles
    corner = np.zeros((mesh.n_cell, 2))  # mean of the squares of the corners' distances
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        corners = shape[:, : CORNERS[kind]]
        x, y = np.moveaxis(corners, -1, 0)
        area = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
        weight[rows] = modulus[rows] * area
        corner[rows] = np.mean((corners - places[rows, None]) ** 2, axis=1)
    # second moment of a rectangle about its middle: a third of that of its corners
    whole = [weight.sum(), *(weight @ (places**2 + corner / 3.0))]
    return float(np.abs(net @ lost / whole).max())


# Neighbours of an edge are the same curve if they meet it at less than this angle [rad] and have
# at most this ratio of radii. The tangents of parabolas through the nodes of a smooth curve differ
# by phi^3 / 3 of the half angle phi of an edge: 0.02 at phi = 22 deg. Where a straight side or a
# smaller fillet begins, the curve has no higher derivatives to be estimated from both sides.
SAME_TANGENT, SAME_RADIUS = 0.17, 10.0
GAUSS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(
    10
)  # exact for x^3 dy of degree 6: 3 * 6 + 5


@dataclass(frozen=True)
class _Edges:
    """Curved edges where the modulus changes: start, middle, end (e, 3, 2); node rows (e, 2)."""

    points: Array
    ends: IntArray

    def beyond(self, half: IntArray) -> Array:
        """Middle and far end (k, 2, 2) of half edges.

        Half edge i begins at the start of edge i, e + i at its end.
        """
        e = len(self.ends)
        points = self.points[half % e]
        return np.where((half < e)[:, None, None], points[:, 1:], points[:, 1::-1])


def _curved_edges(mesh: CellMesh, modulus: Array) -> tuple[_Edges, Array]:
    """Edges, and the modulus left of each, seen along it, less that on its right (e,)."""
    cells, first, second = mesh.edge_table
    points = np.concatenate(
        [
            shape[
                :, np.column_stack([EDGES[KINDS[kind]], CORNERS[kind] + np.arange(CORNERS[kind])])
            ].reshape(-1, 3, 2)[:, [0, 2, 1]]
            for (kind, _), shape in zip(mesh.of_kinds, mesh.shapes, strict=True)
        ]
    )
    forward = first < second
    ends = np.sort(np.column_stack([first, second]), axis=1)
    unique, row, inverse = np.unique(ends, axis=0, return_index=True, return_inverse=True)
    net = np.bincount(inverse.ravel(), np.where(forward, 1.0, -1.0) * modulus[cells])
    points = np.where(forward[row, None, None], points[row], points[row][:, ::-1])
    bow = points[:, 1] - 0.5 * (points[:, 0] + points[:, 2])
    length = np.linalg.norm(points[:, 2] - points[:, 0], axis=1)
    seen = (np.linalg.norm(bow, axis=1) > 1e-9 * length) & (np.abs(net) > 1e-12 * modulus.max())
    return _Edges(points[seen], unique[seen]), net[seen]


def _continued(edges: _Edges) -> tuple[IntArray, IntArray]:
    """Half edges that go on before the start and after the end of each edge, or -1, (e,) each."""
    a, m, b = edges.points.swapaxes(0, 1)
    e = len(a)
    leaving = np.concatenate([4.0 * m - 3.0 * a - b, 4.0 * m - 3.0 * b - a])
    leaving /= np.linalg.norm(leaving, axis=1, keepdims=True)
    chord, bow = b - a, m - 0.5 * (a + b)
    side = np.sign(chord[:, 0] * bow[:, 1] - chord[:, 1] * bow[:, 0])
    turn = side * np.linalg.norm(bow, axis=1) / np.sum(chord**2, axis=1)  # 1 / (8 R)
    turn = np.concatenate([turn, -turn])  # seen along the leaving direction
    node = edges.ends.T.ravel()
    order = np.argsort(node, kind="stable")
    successor, best = np.full(2 * e, -1), np.full(2 * e, np.cos(SAME_TANGENT))
    apart = 1
    while np.any(same := node[order[apart:]] == node[order[:-apart]]):
        one, other = order[:-apart][same], order[apart:][same]
        ratio = -turn[one] / turn[other]
        smooth = -np.sum(leaving[one] * leaving[other], axis=1)
        smooth[(ratio > SAME_RADIUS) | (ratio * SAME_RADIUS < 1.0)] = -1.0
        for here, there in ((one, other), (other, one)):
            better = smooth > best[here]
            successor[here[better]], best[here[better]] = there[better], smooth[better]
        apart += 1
    return successor[:e], successor[e:]


def _moments(points: Array, first: int) -> Array:
    """Area and second moments between the axes and curves, from point `first` to `first + 2`.

    The curves go through all `points` (k, n, 2), with lengths of chords as parameter; the results
    (k, 3) are integrals of x dy, x^3 dy / 3 and -y^3 dx / 3 by Green's theorem. A curve and another
    one with the same ends differ by what lies between them.
    """
    steps = np.linalg.norm(np.diff(points, axis=1), axis=2)
    s = np.concatenate([np.zeros((len(points), 1)), np.cumsum(steps, axis=1)], axis=1)
    middle, half = 0.5 * (s[:, first + 2] + s[:, first]), 0.5 * (s[:, first + 2] - s[:, first])
    s = (s - middle[:, None]) / half[:, None]
    powers = np.arange(points.shape[1])
    factors = np.linalg.solve(s[:, :, None] ** powers, points)
    at = np.einsum("gn,knx->xkg", GAUSS[:, None] ** powers, factors)
    slope = np.einsum(
        "gn,knx->xkg", powers[1:] * GAUSS[:, None] ** (powers[1:] - 1), factors[:, 1:]
    )
    (x, y), (dx, dy) = at, slope
    return (
        np.stack([x * dy, x**3 * dy / 3.0, -(y**3) * dx / 3.0], axis=-1).swapaxes(1, 2)
        @ GAUSS_WEIGHTS
    )


def _slivers_of_arcs(points: Array) -> Array:
    """Area and second moments of what lies between arcs and parabolas through three points, (k, 3).

    A parabola through the ends and the middle of an arc of angle 2 phi has the radius
    R (1 - a^2 s^2 (1 - s^2) / 2), a = 1 - cos phi, -1 < s < 1: a^2 / 15 too small on average.
    """
    chord, bow = points[:, 2] - points[:, 0], points[:, 1] - points[:, ::2].mean(axis=1)
    half, rise = 0.25 * np.sum(chord**2, axis=1), np.sum(bow**2, axis=1)
    a = 2.0 * rise / (half + rise)
    R = 0.5 * (half + rise) / np.sqrt(rise)
    # arc of length 2 R phi, times R a^2 / 15
    sliver = 2.0 * R**2 * np.arccos(1.0 - a) * a**2 / 15.0
    sliver *= np.sign(chord[:, 1] * bow[:, 0] - chord[:, 0] * bow[:, 1])
    return sliver[:, None] * np.column_stack([np.ones(len(points)), points[:, 1] ** 2])


def _removed(degree: int) -> float:
    """Share of an error proportional to degree^-RATE that one degree more removes."""
    return 1.0 - float((degree / (degree + 1.0)) ** RATE)


SHARE = 0.85  # of the error that the refined cells hold


def error_energy(result: Result, better: Result, C: Array) -> Array:
    """Energy of the error in each cell under pairs of the six unit resultants, (c, 6, 6) [1/K].

    The difference of the solutions with this degree and one more, on the same mesh.

    Parameters
    ----------
    result : with the degree of the field
    better : with one degree more
    C : (c, 1 or q, 6, 6) stiffness at the points of `better` [Pa]
    """
    points = result.space.with_rule(better.space.quadrature_degree)
    difference = unit_strains(better.space, better) - unit_strains(points, result)
    own = points.own
    stress = C[own] @ difference
    energy = np.einsum("cq,cqim,cqin->cmn", points.weights[own], difference, stress, optimize=True)
    return points.team.stacked(energy)


def relative(energy: Array, K: Array) -> Array:
    """Energy of each cell under the six unit resultants, relative to that of the section, summed.

    `energy` (c, 6, 6), see `error_energy`; K (6, 6).
    """
    size = np.diag(np.linalg.inv(K))
    return np.asarray((np.einsum("cmm->cm", energy) / size).sum(axis=1))


def worst_cells(error: Array, share: float = SHARE) -> NDArray[np.bool_]:
    """The fewest cells that hold this share of the error, (c,)."""
    marked = np.zeros(len(error), dtype=bool)
    marked[_worst(error, share)] = True
    return marked


def _worst(error: Array, share: float) -> IntArray:
    """Rows of the fewest cells that hold this share of the error, the worst first."""
    order = np.argsort(error)[::-1]
    held = np.cumsum(error[order])
    return order[: int(np.searchsorted(held, share * held[-1])) + 1]


WIDEST = np.radians(30.0)  # element along the circle
WEAKEST = 2e-3  # smaller roots are the translations, lambda = 0 six times, with their rounding
STRAIGHT = np.radians(185.0)  # material around a node of a smooth edge
HELD = 0.95  # share of the error of the cells whose corners are looked at
MOST = 60  # different corners that are solved; each takes 5 to 20 ms
ALIKE = 1e-3  # relative difference of stiffnesses [-] and angles [rad] that are one
X, WEIGHTS = np.polynomial.legendre.leggauss(3)


def cell_exponents(mesh: CellMesh, C: Array, error: Array, regular: float) -> Array:
    """The least exponent lambda at the corners of each cell, `regular` where it is larger, (c,).

    Parameters
    ----------
    C : (c, 1 or q, 6, 6) stiffness of the cells [Pa]
    error : (c,) indicator of the error; cells with little of it are not looked at
    """
    exponents = np.full(mesh.n_cell, regular)
    looked = _worst(error, HELD)
    stiffness = C.mean(axis=1)
    around = _corners_around(mesh)
    known: dict[tuple[float, ...], float] = {}
    corners = (mesh.nodes[cell, : CORNERS[mesh.kind[cell]]].tolist() for cell in looked)
    for node in dict.fromkeys(n for nodes in corners for n in nodes):
        angles, cells = around[node]
        wedges = _wedges(angles, cells, stiffness)
        if wedges is None:
            continue
        ends, materials, closed = wedges
        scale = float(np.abs(materials).max())
        key = (*np.round(ends / ALIKE), *np.round(materials.ravel() / scale / ALIKE), closed)
        if key not in known:
            if len(known) == MOST:
                break
            known[key] = exponent(ends, materials, closed=closed)
        exponents[cells] = np.minimum(exponents[cells], known[key])
    return exponents


def exponent(ends: Array, C: Sequence[Array] | Array, *, closed: bool) -> float:
    """The least real part above 0 of lambda for the wedges around a point, at most 1.

    Parameters
    ----------
    ends : (w + 1,) angles at which the wedges begin and end, rising [rad]
    C : (w, 6, 6) stiffness of each wedge in the axes of the angles [Pa]
    closed : whether the last wedge touches the first one
    """
    counts = np.ceil(np.diff(ends) / WIDEST - 1e-9).astype(int)
    parts = zip(ends[:-1], ends[1:], counts.tolist(), strict=True)
    lines = np.concatenate([*(np.linspace(a, b, n + 1)[:-1] for a, b, n in parts), ends[-1:]])
    owner = np.repeat(np.arange(len(counts)), counts)
    n = 2 * len(owner) + (0 if closed else 1)
    material = np.asarray(C)[owner, None] / float(np.abs(C).max())
    half = 0.5 * np.diff(lines)[:, None]
    theta = 0.5 * (lines[:-1] + lines[1:])[:, None] + half * X  # (elements, points)
    # strains of the unknowns 3 i + a of an element by r^lambda itself, and by its slope
    N = np.stack([0.5 * X * (X - 1.0), 1.0 - X * X, 0.5 * X * (X + 1.0)], axis=1)
    dN = np.stack([X - 0.5, -2.0 * X, X + 0.5], axis=1) / half[..., None]
    shape = (*theta.shape, 6, 9)
    radial = (_strain(np.cos(theta), np.sin(theta)) * N[:, None, :, None]).reshape(shape)
    around = (_strain(-np.sin(theta), np.cos(theta)) * dN[:, :, None, :, None]).reshape(shape)
    stress = (half * WEIGHTS)[..., None, None] * (material @ np.stack([around, radial]))
    parts = np.einsum("xegri,yegrj->xyeij", np.stack([around, radial]), stress, optimize=True)
    A0, A1, A2 = np.zeros((3, 3 * n, 3 * n))
    for e, ((of_A0, mixed), (_, of_A2)) in enumerate(np.moveaxis(parts, 2, 0)):
        at = (3 * (np.arange(2 * e, 2 * e + 3) % n)[:, None] + np.arange(3)).ravel()
        A0[np.ix_(at, at)] += of_A0
        A1[np.ix_(at, at)] += mixed - mixed.T
        A2[np.ix_(at, at)] -= of_A2
    lower = -np.linalg.solve(A2, np.hstack([A0, A1]))
    upper = np.hstack([np.zeros_like(A0), np.eye(3 * n)])
    roots = la.eigvals(np.vstack([upper, lower])).real
    return float(min(roots[roots > WEAKEST].min(initial=1.0), 1.0))


def _strain(d2: Array, d3: Array) -> Array:
    """Strains 11, 22, 33, 23, 13, 12 of displacements with these derivatives along x2, x3, (..., 6,
    1, 3)."""
    by_2, by_3 = np.zeros((2, 6, 1, 3))
    by_2[[1, 3, 5], 0, [1, 2, 0]] = by_3[[2, 3, 4], 0, [2, 1, 0]] = 1.0
    return np.multiply.outer(d2, by_2) + np.multiply.outer(d3, by_3)


def _corners_around(mesh: CellMesh) -> dict[int, tuple[Array, IntArray]]:
    """Of each node that is a corner: (k, 2) angles at which its cells begin and end, the cells."""
    nodes, cells, starts, ends = [], [], [], []
    for kind, rows in mesh.of_kinds:
        corner = mesh.nodes[rows, : CORNERS[kind]]
        at, after, before = (mesh.points[np.roll(corner, k, axis=1)] for k in (0, -1, 1))
        a, b = after - at, before - at
        start = np.arctan2(a[..., 1], a[..., 0])
        opening = np.arctan2(b[..., 1], b[..., 0]) - start
        nodes.append(corner.ravel())
        cells.append(np.repeat(rows, CORNERS[kind]))
        starts.append(start.ravel())
        ends.append((start + np.mod(opening, 2.0 * np.pi)).ravel())
    every = np.concatenate(nodes)
    order = np.argsort(every, kind="stable")
    first = np.flatnonzero(np.diff(every[order], prepend=-1))
    angles = np.stack([np.concatenate(starts), np.concatenate(ends)], axis=1)
    owner = np.concatenate(cells)
    return {int(every[rows[0]]): (angles[rows], owner[rows]) for rows in np.split(order, first[1:])}


def _wedges(angles: Array, cells: IntArray, stiffness: Array) -> tuple[Array, Array, bool] | None:
    """Ends and stiffness of the wedges around a node, in axes along the beginning of the first one.

    None where stresses are not singular, and where cells leave more than one gap.
    """
    widths = angles[:, 1] - angles[:, 0]
    C = stiffness[cells]
    one = bool(np.abs(C - C[0]).max() <= ALIKE * np.abs(C[0]).max())
    total = float(widths.sum())
    closed = total > 2.0 * np.pi - ALIKE
    if one and (closed or total < STRAIGHT):
        return None
    order = np.argsort(angles[:, 0])
    gap = np.roll(angles[order, 0], -1) - angles[order, 1]  # to the next cell around the node
    apart = np.flatnonzero(np.abs(np.mod(gap + np.pi, 2.0 * np.pi) - np.pi) >= ALIKE)
    if len(apart) != (0 if closed else 1):
        return None
    C = stiffness[cells[order]]
    change = np.abs(np.roll(C, -1, axis=0) - C).max(axis=(1, 2))
    begin = 1 + int(np.argmax(change) if closed else apart[0])  # where the material changes
    order, C = np.roll(order, -begin), np.roll(C, -begin, axis=0)
    ends = angles[order[0], 0] + np.concatenate([[0.0], np.cumsum(widths[order])])
    change = np.abs(np.diff(C, axis=0)).max(axis=(1, 2)) > ALIKE * np.abs(C).max()
    keep = np.concatenate([[True], change])
    materials = C[keep]
    bounds = np.append(ends[:-1][keep], ends[-1])
    if closed and len(materials) == 2 and abs(bounds[1] - bounds[0] - np.pi) < 0.05:
        return None  # a straight interface
    # seen from the edge where the first wedge begins: corners that differ by a turn are one
    c, s = np.cos(bounds[0]), np.sin(bounds[0])
    seen = rotated(materials, np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]))
    return bounds - bounds[0], seen, closed
