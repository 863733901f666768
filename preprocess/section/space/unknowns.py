"""Unknowns of a section that are not displacements of nodes: at hanging nodes, across thin walls.

Unknowns for thin walls are the displacement of one face, and differences across the wall.
In a wall of thickness t and length w the stiffness in bending is (t/w)^4 times the stiffness of a
cell against stretching across the wall. With displacements of nodes as unknowns, this is lost in
rounding below t/w = 1e-4. With differences across the wall as unknowns, which are
rotations of the wall times t, the ratio is (t/w)^2.
"""

from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ....solver.math.arrays import Array, IntArray

SMALL, CORNER = 1e-3, 1e-2  # size of cells, and of a part of such cells, over that of the section
THIN = 8.0  # size of a cell over the distance of two of its nodes that are treated as one place


class Unknowns:
    """Values of the nodes = P z, with unknowns z.

    Parameters
    ----------
    P : (n_node, n_unknown)
    R : (n_unknown, n_node) with R P = 1: the unknowns of values that the unknowns can take
    whole : (w,) unknowns that are the values of nodes `at` (w,)
    """

    def __init__(self, P: sp.csr_matrix, R: sp.csr_matrix, whole: IntArray, at: IntArray) -> None:
        self.P, self.R, self.whole, self.at = P.tocsr(), R.tocsr(), whole, at

    def of_nodes(self, nodal: Array) -> Array:
        """Unknowns (n_unknown, ...) of nodal values (n_node, ...)."""
        return np.asarray(self.R @ nodal.reshape(len(nodal), -1)).reshape(-1, *nodal.shape[1:])

    def at_nodes(self, z: Array) -> Array:
        """Nodal values (n_node, ...) of unknowns (n_unknown, ...)."""
        return np.asarray(self.P @ z.reshape(len(z), -1)).reshape(-1, *z.shape[1:])

    def then(self, others: "Unknowns") -> "Unknowns":
        """These unknowns as given by others."""
        return Unknowns(self.P @ others.P, others.R @ self.R, others.whole, self.at[others.at])

    def of_cells(self, dofs: IntArray) -> tuple[IntArray, Array]:
        """Unknowns of cells with nodes (c, k), as (c, m), and the part of P of each, (c, k, m).

        Cells with fewer unknowns repeat their first one with zeros.
        """
        c, k = dofs.shape
        picked = self.P[dofs.ravel()].tocoo()
        cell = picked.row // k
        key = cell.astype(np.int64) * self.P.shape[1] + picked.col
        unique, place = np.unique(key, return_inverse=True)
        owner = unique // self.P.shape[1]
        first = np.searchsorted(owner, np.arange(c))
        local = np.arange(len(unique)) - first[owner]
        m = int(local.max()) + 1
        table = np.repeat((unique[first] % self.P.shape[1])[:, None], m, axis=1)
        table[owner, local] = unique % self.P.shape[1]
        parts = np.zeros((c, k, m))
        parts[cell, picked.row % k, local[place.ravel()]] = picked.data
        return table, parts


def hanging_unknowns(P: sp.csr_matrix) -> Unknowns:
    """The unknowns of a mesh with hanging nodes: the values of all other nodes."""
    single = np.flatnonzero(np.diff(P.indptr) == 1)
    single = single[np.abs(P.data[P.indptr[single]] - 1.0) < 1e-12]
    columns, first = np.unique(P.indices[P.indptr[single]], return_index=True)
    n = P.shape[1]
    assert len(columns) == n, "an unknown without a node"
    at = single[first]
    R = sp.csr_matrix((np.ones(n), (np.arange(n), at)), shape=(n, P.shape[0]))
    return Unknowns(P, R, np.arange(n), at)


def differences_across(x: Array, dofs: IntArray, *, corners: bool = True) -> Unknowns | None:
    """Unknowns in which walls of one thin cell or several are well conditioned; None without them.

    Nodes at one place of a wall form a group. Its two outermost nodes give the linear
    displacement through the wall; all other nodes have their difference from it as unknown. With
    `corners`, a corner of walls is one group: walls of t/w = 1e-5 need it. It is worse for a
    twisted strip, which deforms at its ends.

    Parameters
    ----------
    x : (n_unknown, 2) places of the unknowns, which are displacements of nodes [m]
    dofs : (c, k) unknowns of each cell
    """
    n = len(x)
    places = x[dofs]  # (c, k, 2)
    size = np.ptp(places, axis=1).max(axis=1)
    away = np.abs(places[:, :, None] - places[:, None]).max(axis=-1)
    cell, i, j = np.nonzero(away * THIN < size[:, None, None])
    pairs = np.stack([dofs[cell, i], dofs[cell, j]], axis=1)
    if corners:
        small = size < SMALL * np.ptp(x, axis=0).max()
        pairs = np.concatenate([pairs, _corner_pairs(dofs[small], x)])
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
