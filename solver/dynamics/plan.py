"""Structure of a mechanism, computed once: rows and columns that the step loop uses.

Every body has one dense block of M and of the Jacobian. Bodies are eliminated first, one by one.
The remaining symmetric matrix of the constraint rows couples two joints only if they
share a body. Its rows are ordered for cheap elimination in the profile below the diagonal:
linear in the number of bodies of a chain, slightly more for a tree of limited branching.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..math.arrays import Array, IntArray


class Plan(NamedTuple):
    """Integers that depend only on bodies, markers and joints."""

    widest: int  # coordinates of the largest body
    most_modes: int
    most_rows: int  # constraint rows at the busiest body
    structured: int  # 1: every body has a positive definite mass matrix of its own
    marker_used: IntArray  # markers on bodies that joints and force elements use
    size: IntArray  # (nb,) coordinates of each body
    lead: IntArray  # (nb,) a mode is coupled with so many leading coordinates: 6, or all of them
    base: IntArray  # (nb,) first coordinate that is eliminated: 6 where the frame is driven
    row_start: IntArray  # (nb + 1,) first entry of each body in body_row
    body_row: IntArray  # every constraint row at a body
    side_row: IntArray  # (nj, 2) first row of a joint's side among the rows at its body; -1: ground
    free_start: IntArray  # (nb + 1,) first entry of each body in the next two
    free_column: IntArray  # rows at a body that do not drive its frame: their number there
    free_place: IntArray  # and their position in the order of elimination
    driven_start: IntArray  # (nb + 1,) first entry of each body in the next two
    driven_column: IntArray  # the six rows that drive a frame: their number at the body
    driven_row: IntArray  # and among all rows
    place: (
        IntArray  # (n_c,) position of each row in the order of elimination; -1: it drives a frame
    )
    first: IntArray  # (n_p,) first column of each position in the profile
    profile_start: IntArray  # (n_p + 1,) of the rows of the profile


def make_plan(
    n_mode: IntArray,
    marker_body: IntArray,
    joint_marker: IntArray,
    joint_row: IntArray,
    force_marker: IntArray,
    *,
    structured: bool,
    uncoupled: Sequence[bool] = (),
    driven: IntArray | None = None,
) -> Plan:
    """Return the plan of a mechanism; arguments as in `Model`.

    Parameters
    ----------
    structured : every body has a positive definite mass matrix of its own
    uncoupled : by body, whether its modes have diagonal mass, stiffness and damping; none if empty
    driven : (nj,) the body whose frame a joint drives, alone or with others (driven.py); -1: none
    """
    nb, nj = n_mode.size, joint_row.size - 1
    used = np.unique(np.concatenate([joint_marker.ravel(), force_marker.ravel()]).astype(np.int64))
    bodies = marker_body[joint_marker].reshape(nj, 2)
    driven = np.full(nj, -1) if driven is None else driven
    place, first = _order(bodies, joint_row, driven < 0)
    side_row = np.full((nj, 2), -1, dtype=np.int64)
    at_body: list[list[int]] = [[] for _ in range(nb)]
    for k in range(nj):
        for side in range(2):
            if bodies[k, side] >= 0:
                rows = at_body[bodies[k, side]]
                side_row[k, side] = len(rows)
                rows.extend(range(joint_row[k], joint_row[k + 1]))
    free = [[p for p, row in enumerate(rows) if place[row] >= 0] for rows in at_body]
    drives = [[p for p, row in enumerate(rows) if place[row] < 0] for rows in at_body]
    counts = [len(rows) for rows in at_body]
    lead = np.where(np.array(uncoupled, dtype=bool), 6, 6 + n_mode) if uncoupled else 6 + n_mode
    base = np.zeros(nb, dtype=np.int64)
    base[driven[driven >= 0]] = 6
    return Plan(
        widest=int((6 + n_mode).max(initial=6)),
        most_modes=int(n_mode.max(initial=0)),
        most_rows=max(counts, default=0),
        structured=int(structured),
        marker_used=used[marker_body[used] >= 0] if used.size else used,
        size=6 + n_mode,
        lead=lead.astype(np.int64),
        base=base,
        row_start=_starts(counts),
        body_row=_joined(at_body),
        side_row=side_row,
        free_start=_starts([len(p) for p in free]),
        free_column=_joined(free),
        free_place=place[_picked(at_body, free)],
        driven_start=_starts([len(p) for p in drives]),
        driven_column=_joined(drives),
        driven_row=_picked(at_body, drives),
        place=place,
        first=first,
        profile_start=_starts((np.arange(first.size) - first + 1).tolist()),
    )


def _joined(lists: Sequence[Sequence[int]]) -> IntArray:
    return np.array([value for one in lists for value in one], dtype=np.int64)


def _picked(at_body: list[list[int]], numbers: list[list[int]]) -> IntArray:
    return _joined([[rows[p] for p in n] for rows, n in zip(at_body, numbers, strict=True)])


def _order(
    bodies: IntArray, joint_row: IntArray, free: NDArray[np.bool_]
) -> tuple[IntArray, IntArray]:
    """Return positions (n_c,) of the rows of free joints, -1 for others, and their first
    columns."""
    counts = np.diff(joint_row)[free]
    bodies, row = bodies[free], _starts(counts.tolist())
    compact = _places(bodies, row, int(row[-1]))
    place = np.full(int(joint_row[-1]), -1, dtype=np.int64)
    place[np.repeat(free, np.diff(joint_row))] = compact
    return place, _first_columns(bodies, row, compact)


def _places(bodies: IntArray, joint_row: IntArray, n_c: int) -> IntArray:
    """Return the position (n_c,) of each row, with joints that share bodies close together.

    Selects the cheaper of two orders: reverse Cuthill-McKee for chains and rings, or leaves first
    for trees, for which the first has a large bandwidth.
    """
    if len(bodies) == 0:
        return np.zeros(0, dtype=np.int64)
    choice = [
        _rows_in_order(order, joint_row, n_c) for order in (_narrow(bodies), _leaves_first(bodies))
    ]
    costs = [_cost(_first_columns(bodies, joint_row, place)) for place in choice]
    return choice[int(np.argmin(costs))]


def _rows_in_order(order: Sequence[int], joint_row: IntArray, n_c: int) -> IntArray:
    """Return the position (n_c,) of each row, with the joints in a given order."""
    place = np.empty(n_c, dtype=np.int64)
    n = 0
    for k in order:
        rows = np.arange(joint_row[k], joint_row[k + 1])
        place[rows] = n + np.arange(rows.size)
        n += rows.size
    return place


def _first_columns(bodies: IntArray, joint_row: IntArray, place: IntArray) -> IntArray:
    """Return the first column (n_c,) of each position: that of the first row at the same bodies."""
    begin = place[joint_row[:-1]]
    least = np.full(int(bodies.max(initial=-1)) + 2, place.size)  # the last one is the ground's
    for side in range(2):
        np.minimum.at(least, bodies[:, side], begin)
    least[-1] = place.size
    first = np.empty(place.size, dtype=np.int64)
    first[place] = np.repeat(np.minimum(least[bodies].min(axis=1), begin), np.diff(joint_row))
    return first


def _cost(first: IntArray) -> int:
    """Return the number of multiplications of an elimination in a profile."""
    column = np.arange(first.size)
    return sum(
        int((column[begin:row] - np.maximum(first[begin:row], begin)).sum() + row - begin)
        for row, begin in enumerate(first)
    )


def _narrow(bodies: IntArray) -> list[int]:
    """Return the order of joints by Cuthill and McKee on the graph of joints that share a body."""
    joint, side = np.nonzero(bodies >= 0)
    incidence = coo_matrix(
        (np.ones(joint.size), (joint, bodies[joint, side])),
        shape=(len(bodies), int(bodies.max()) + 1),
    ).tocsr()
    graph = (incidence @ incidence.T).tocsr()
    return [int(k) for k in reverse_cuthill_mckee(graph, symmetric_mode=True)]


def _leaves_first(bodies: IntArray) -> list[int]:
    """Return the order of joints with the branches of a body before the joint that supports it.

    The largest of several branches comes first. The following joints then reach back only over
    the others, for a tree of n bodies over n log n positions in total.
    """
    ground = int(bodies.max()) + 1
    at_body: list[list[tuple[int, int]]] = [[] for _ in range(ground + 1)]
    for k, pair in enumerate(np.where(bodies < 0, ground, bodies).tolist()):
        at_body[pair[0]].append((k, pair[1]))
        at_body[pair[1]].append((k, pair[0]))
    holder: dict[int, int] = {}  # body -> joint that supports it
    branches: list[list[int]] = [[] for _ in range(ground + 1)]
    size = [0] * (ground + 1)
    roots, found = [], [False] * (ground + 1)
    for root in (ground, *range(ground)):
        if found[root]:
            continue
        roots.append(root)
        found[root], line = True, [root]
        for body in line:
            for k, other in at_body[body]:
                if not found[other]:
                    found[other], holder[other] = True, k
                    branches[body].append(other)
                    line.append(other)
        for body in reversed(line):
            size[body] = 1 + sum(size[other] for other in branches[body])
    before: list[int] = []  # every body before its branches, the smallest branch first
    stack = roots
    while stack:
        body = stack.pop()
        before.append(body)
        stack.extend(sorted(branches[body], key=lambda other: -size[other]))
    holding = set(holder.values())
    order: dict[int, None] = {}
    for body in reversed(before):
        # joints that close a loop come before the one that supports the body
        order.update((k, None) for k, _ in at_body[body] if k not in holding and k not in order)
        if body in holder:
            order[holder[body]] = None
    return list(order)


def _starts(sizes: Sequence[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def positive_inertia(mass: float, J: Array, M_wq: Array, S0: Array, S: Array, M_qq: Array) -> bool:
    """True if the mass matrix of a body at rest is positive definite, after scaling.

    mass [kg], J (3, 3) is the inertia about the frame, M_wq (3, m) its coupling with the modes.
    """
    x, y, z = S0
    top = np.hstack([mass * np.eye(3), -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), S])
    middle = np.hstack([top[:, 3:6].T, J, M_wq])
    M = np.vstack([top, middle, np.hstack([S.T, M_wq.T, M_qq])])
    scale = np.sqrt(np.diag(M).clip(min=0.0))
    if not (scale > 0.0).all():
        return False
    return bool(np.linalg.eigvalsh(M / np.outer(scale, scale))[0] > 1e-10)
