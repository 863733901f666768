"""Singular stresses where materials, edges and re-entrant corners meet: how slowly errors fall.

Near such a point the displacement is r^lambda phi(theta) (Williams 1952; Leguillon and
Sanchez-Palencia 1987). The energy of the error of a field of degree p in the cells around it falls
with p^(-4 lambda) (Babuska and Suri 1987). lambda is 0.54 at a corner of 270 deg, and tends to 0
where stiff and soft quarters meet crosswise.
"""

from collections.abc import Sequence

import numpy as np
import scipy.linalg as la

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.materials import rotated
from ..mesh.cells import CORNERS, CellMesh

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
    found = np.full(mesh.n_cell, regular)
    order = np.argsort(error)[::-1]
    held = np.cumsum(error[order])
    looked = order[: int(np.searchsorted(held, HELD * held[-1])) + 1]
    stiffness = C.mean(axis=1)
    around = _corners_around(mesh)
    known: dict[tuple[float, ...], float] = {}
    for node in dict.fromkeys(n for cell in looked for n in _corner_nodes(mesh, cell).tolist()):
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
        found[cells] = np.minimum(found[cells], known[key])
    return found


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


def _corner_nodes(mesh: CellMesh, cell: int) -> IntArray:
    return mesh.nodes[cell, : CORNERS[mesh.kind[cell]]]


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
    """Ends and stiffness of the wedges around a node, in axes along the beginning of the first one;
    None where stresses are not singular."""
    widths = angles[:, 1] - angles[:, 0]
    C = stiffness[cells]
    one = bool(np.abs(C - C[0]).max() <= ALIKE * np.abs(C[0]).max())
    total = float(widths.sum())
    closed = total > 2.0 * np.pi - ALIKE
    if one and (closed or total < STRAIGHT):
        return None
    order = _rising(angles, closed)
    if order is None:
        return None
    ends = angles[order[0], 0] + np.concatenate([[0.0], np.cumsum(widths[order])])
    C = C[order]
    if closed and not one:  # begin where the material changes
        change = np.abs(C - np.roll(C, 1, axis=0)).max(axis=(1, 2))
        begin = int(np.argmax(change))
        order, C = [*order[begin:], *order[:begin]], np.roll(C, -begin, axis=0)
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


def _rising(angles: Array, closed: bool) -> list[int] | None:
    """Cells around a node one after the other; None if they leave more than one gap."""
    n = len(angles)
    gap = np.mod(angles[None, :, 0] - angles[:, None, 1] + np.pi, 2.0 * np.pi) - np.pi
    following = np.abs(gap) < ALIKE
    lonely = np.flatnonzero(~following.any(axis=0))
    if len(lonely) != (0 if closed else 1):
        return None
    order = [0 if closed else int(lonely[0])]
    while len(order) < n:
        after = np.flatnonzero(following[order[-1]])
        if not after.size:
            return None
        order.append(int(after[0]))
    return order
