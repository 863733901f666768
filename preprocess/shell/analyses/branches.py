"""The best lay-up of given angles, by branch and bound over its plies from the outside in.

A branch has the angles of its outer plies. The others have shares of all given angles, so the best
mixture for some cutting planes (mixtures.py) bounds all lay-ups of the branch. A branch is split by
the angles of its next ply, and the search goes on with the best of them, down to a lay-up; this
shell is computed, and its modes give more planes. Then it goes on with the branch of the largest
bound. Branches whose bound is above the best lay-up by less than `CERTIFIED` are left.
"""

import heapq
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array
from .mixtures import AGREED, Basis, Cuts, Plies

Angles = tuple[float, ...]  # of the outer plies, from the outside in
CERTIFIED = 1e-4  # relative difference of lambda
MOST_BRANCHES = 3000
MOST_CUTS = 8  # rounds of cutting planes of a branch


class Best(NamedTuple):
    """The best lay-up of given angles.

    Attributes
    ----------
    value, angles_deg : its lambda, and its angles (g,)
    bound : of lambda of all lay-ups
    branches, computed : counts of branches with a bound, and of lay-ups with modes of the shell
    """

    value: float
    angles_deg: Array
    bound: float
    branches: int
    computed: int


def best_of_angles(
    plies: Plies,
    cuts: Cuts,
    basis_of: Callable[[Array], Basis],
    modes: Callable[[Array], tuple[Array, Array]],
    X: Array,
    angles_deg: Array,
    first: Array,
) -> Best:
    """Branch and bound.

    Parameters
    ----------
    basis_of : the shell in a basis of modes X
    modes : lambda and modes of the shell with plies of some angles (g,)
    angles_deg : (a,) those of each ply
    first : (g,) a lay-up of them
    """
    order = np.argsort(-np.abs(plies.columns[:, 8:]).max(axis=(1, 2)), kind="stable")
    best, most, discarded, branches = first, 0.0, 0.0, 0
    computed: set[Angles] = set()
    basis = basis_of(X)

    def bounded(fixed: Angles, limit: float) -> float:
        allowed = [angles_deg] * len(order)
        for ply, angle in zip(order, fixed, strict=False):
            allowed[ply] = np.array([angle])
        for _ in range(MOST_CUTS):
            mixture = cuts.best(allowed)
            limit = min(limit, mixture.bound)
            here = basis.value(mixture.p) * (1.0 + AGREED)
            if limit <= max(most * (1.0 + CERTIFIED), here):
                break
            cuts.add(*basis.cuts(mixture.p))
        return limit

    open_: list[tuple[float, Angles]] = [(-np.inf, ()), (-np.inf, tuple(first[order]))]
    below: list[tuple[float, Angles]] = []
    while open_ and (below or branches < MOST_BRANCHES):
        # down to a lay-up along the best branches, then from the best of all
        minus, fixed = below.pop() if below else heapq.heappop(open_)
        children: list[Angles] = []
        if -minus <= most * (1.0 + CERTIFIED):
            discarded = max(discarded, -minus)
        elif len(fixed) < len(order):
            children = [(*fixed, angle) for angle in angles_deg.tolist()]
        elif fixed not in computed:
            limit = bounded(fixed, -minus)
            if limit <= most * (1.0 + CERTIFIED):
                discarded = max(discarded, limit)
            else:
                computed.add(fixed)
                tried = np.array(fixed)[np.argsort(order)]
                values, more = modes(tried)
                X = np.c_[X, more]
                basis = basis_of(X)
                if values[0] > most:
                    best, most = tried, float(values[0])
        ranked = sorted((-bounded(child, -minus), child) for child in children)
        branches += len(ranked)
        below = ranked[:1]
        for each in ranked[1:]:
            heapq.heappush(open_, each)
    left = -min(open_, default=(0.0, ()))[0]
    return Best(most, best, max(most, discarded, left), branches, len(computed))
