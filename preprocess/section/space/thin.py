"""Unknowns for thin walls: the displacement of one face, and differences across the wall.

In a wall of thickness t and length w the stiffness in bending is (t/w)^4 times the stiffness of a
cell against stretching across the wall. With displacements of nodes as unknowns, this is
lost in rounding below t/w = 1e-4. With differences across the wall as unknowns, which are
rotations of the wall times t, the ratio is (t/w)^2.
"""

from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from .space import SectionSpace, Unknowns

SMALL, CORNER = 1e-3, 1e-2  # size of cells, and of a part of such cells, over that of the section
THIN = 8.0  # size of a cell over the distance of two of its nodes that are treated as one place


def differences_across(space: SectionSpace, *, corners: bool = True) -> Unknowns | None:
    """Unknowns in which walls of one thin cell or several are well conditioned; None without them.

    Nodes at one place of a wall form a group. Its two outermost nodes give the linear
    displacement through the wall; all other nodes have their difference from it as unknown. With
    `corners`, a corner of walls is one group: walls of t/w = 1e-5 need it. It is worse for a
    twisted strip, which deforms at its ends.
    """
    n = space.n_unknown
    at = np.arange(n) if space.unknowns is None else space.unknowns.at
    x = np.stack([space.x2, space.x3], axis=1)[at]
    places = x[space.dofs]  # (c, k, 2)
    size = np.ptp(places, axis=1).max(axis=1)
    away = np.abs(places[:, :, None] - places[:, None]).max(axis=-1)
    cell, i, j = np.nonzero(away * THIN < size[:, None, None])
    pairs = np.stack([space.dofs[cell, i], space.dofs[cell, j]], axis=1)
    if corners:
        small = size < SMALL * np.ptp(x, axis=0).max()
        pairs = np.concatenate([pairs, _corner_pairs(space.dofs[small], x)])
    group = _parts(pairs, n)
    members = np.argsort(group, kind="stable")
    bounds = np.flatnonzero(np.diff(group[members], prepend=-1, append=-1))
    rows, columns, values = [], [], []
    whole = np.ones(n, dtype=bool)
    for start, stop in pairwise(bounds):
        if stop - start < 2:
            continue
        some = members[start:stop]
        a, b, s = _ends(x[some])
        for column, weight in ((some[a], 1.0 - s), (some[b], s)):
            others = np.delete(np.arange(len(some)), [a, b])
            rows.append(some[others])
            columns.append(np.full(len(others), column))
            values.append(weight[others])
        # the other end: its difference from the first
        rows.append(some[[b]])
        columns.append(some[[a]])
        values.append(np.ones(1))
        whole[np.delete(some, a)] = False
    if not rows:
        return None
    # u = z + N u, where the rows of N refer to ends only
    size_n = (n, n)
    N = sp.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=size_n
    )
    one = sp.identity(n, format="csr")
    return Unknowns(one + N + N @ N, one - N, np.flatnonzero(whole), np.flatnonzero(whole))


def _corner_pairs(some: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Pairs of nodes (m, 2) of the small cells (s, k) where thin walls meet or end.

    Such a corner turns as a whole when its walls bend, with hardly any strain of its cells.
    """
    pairs = np.stack([np.repeat(some[:, 0], some.shape[1] - 1), some[:, 1:].ravel()], axis=1)
    part = _parts(pairs, len(x))
    low, high = np.full((2, part.max() + 1, 2), np.inf)
    high = -high
    np.minimum.at(low, part, x)
    np.maximum.at(high, part, x)
    # not a wall of small cells
    compact = (high - low).max(axis=1) < CORNER * np.ptp(x, axis=0).max()
    return np.asarray(pairs[compact[part[pairs[:, 0]]]])


def _parts(pairs: np.ndarray, n: int) -> np.ndarray:
    """Number of the connected part of each of n nodes."""
    links = sp.csr_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(n, n))
    return np.asarray(connected_components(links, directed=False)[1])


def _ends(x: np.ndarray) -> tuple[int, int, np.ndarray]:
    """The two outermost of some places (m, 2), and the position of all between them, 0 to 1."""
    a = int(np.argmax(np.abs(x - x[0]).sum(axis=1)))
    b = int(np.argmax(np.abs(x - x[a]).sum(axis=1)))
    along = x[b] - x[a]
    return a, b, (x - x[a]) @ along / float(along @ along)
