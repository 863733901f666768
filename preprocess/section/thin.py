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

from .space import SectionSpace
from .unknowns import Unknowns

THIN = 8.0  # size of a cell over the distance of two of its nodes that are treated as one place


def differences_across(space: SectionSpace) -> Unknowns | None:
    """Unknowns in which walls of one thin cell or several are well conditioned; None without them.

    Nodes at one place of a wall form a group. Its two outermost nodes give the linear
    displacement through the wall; all other nodes have their difference from it as unknown.
    """
    n = space.n_unknown
    at = np.arange(n) if space.unknowns is None else space.unknowns.at
    x = np.stack([space.x2, space.x3], axis=1)[at]
    corners = x[space.dofs]  # (c, k, 2)
    size = np.ptp(corners, axis=1).max(axis=1)
    away = np.abs(corners[:, :, None] - corners[:, None]).max(axis=-1)
    cell, i, j = np.nonzero(away * THIN < size[:, None, None])
    first, second = space.dofs[cell, i], space.dofs[cell, j]
    links = sp.csr_matrix((np.ones(len(first)), (first, second)), shape=(n, n))
    _, group = connected_components(links, directed=False)
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


def _ends(x: np.ndarray) -> tuple[int, int, np.ndarray]:
    """The two outermost of some places (m, 2), and the position of all between them, 0 to 1."""
    a = int(np.argmax(np.abs(x - x[0]).sum(axis=1)))
    b = int(np.argmax(np.abs(x - x[a]).sum(axis=1)))
    along = x[b] - x[a]
    return a, b, (x - x[a]) @ along / float(along @ along)
