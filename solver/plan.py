"""What a mechanism's structure fixes once: which rows and columns the step loop touches.

Every body has one dense block of M and of the Jacobian. Bodies are eliminated first, one by one;
what is left is a symmetric matrix of the constraint rows, in which two joints meet only if they
share a body. Its rows are ordered so that the profile below the diagonal stays narrow: the cost
of an evaluation is linear in the number of bodies of a chain or a tree of limited branching.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from .package.schema import Array, IntArray


class Plan(NamedTuple):
    """Integers that follow from bodies, markers and joints alone."""

    widest: int  # coordinates of the largest body
    most_modes: int
    most_rows: int  # constraint rows at the busiest body
    structured: int  # 1: every body has a positive definite mass matrix of its own
    marker_used: IntArray  # markers on bodies that joints and force elements stand on
    size: IntArray  # (nb,) coordinates of each body
    row_start: IntArray  # (nb + 1,) first entry of each body in body_place
    body_place: IntArray  # place, in the order of elimination, of every row at a body
    side_row: IntArray  # (nj, 2) first row of a joint's side among the rows at its body; -1: ground
    place: IntArray  # (n_c,) place of each constraint row in the order of elimination
    first: IntArray  # (n_c,) first column of each place in the profile
    profile_start: IntArray  # (n_c + 1,) of the rows of the profile


def make_plan(
    n_mode: IntArray,
    marker_body: IntArray,
    joint_marker: IntArray,
    joint_row: IntArray,
    force_marker: IntArray,
    *,
    structured: bool,
) -> Plan:
    """Return the plan of a mechanism; arguments as in `Model`."""
    nb, nj, n_c = n_mode.size, joint_row.size - 1, int(joint_row[-1])
    used = np.unique(np.concatenate([joint_marker.ravel(), force_marker.ravel()]).astype(np.int64))
    bodies = marker_body[joint_marker].reshape(nj, 2)
    place = _places(bodies, joint_row, n_c)
    side_row = np.full((nj, 2), -1, dtype=np.int64)
    at_body: list[list[int]] = [[] for _ in range(nb)]
    for k in range(nj):
        for side in range(2):
            if bodies[k, side] >= 0:
                rows = at_body[bodies[k, side]]
                side_row[k, side] = len(rows)
                rows.extend(place[joint_row[k] : joint_row[k + 1]].tolist())
    first = np.arange(n_c, dtype=np.int64)
    for rows in at_body:
        if rows:
            first[rows] = np.minimum(first[rows], min(rows))
    widths = np.arange(n_c) - first + 1
    counts = [len(rows) for rows in at_body]
    return Plan(
        widest=int((6 + n_mode).max(initial=6)),
        most_modes=int(n_mode.max(initial=0)),
        most_rows=max(counts, default=0),
        structured=int(structured),
        marker_used=used[marker_body[used] >= 0] if used.size else used,
        size=6 + n_mode,
        row_start=_starts(counts),
        body_place=np.array([row for rows in at_body for row in rows], dtype=np.int64),
        side_row=side_row,
        place=place,
        first=first,
        profile_start=_starts(widths.tolist()),
    )


def _places(bodies: IntArray, joint_row: IntArray, n_c: int) -> IntArray:
    """Return the place (n_c,) of each row: joints that share bodies stand close together."""
    nj = len(bodies)
    if nj == 0:
        return np.zeros(0, dtype=np.int64)
    joint, side = np.nonzero(bodies >= 0)
    incidence = coo_matrix(
        (np.ones(joint.size), (joint, bodies[joint, side])), shape=(nj, int(bodies.max()) + 1)
    ).tocsr()
    graph = (incidence @ incidence.T).tocsr()
    order = reverse_cuthill_mckee(graph, symmetric_mode=True)
    place = np.empty(n_c, dtype=np.int64)
    n = 0
    for k in order:
        rows = np.arange(joint_row[k], joint_row[k + 1])
        place[rows] = n + np.arange(rows.size)
        n += rows.size
    return place


def _starts(sizes: Sequence[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def positive_inertia(mass: float, J: Array, M_wq: Array, S0: Array, S: Array, M_qq: Array) -> bool:
    """Tell whether a body's own mass matrix at rest is positive definite, units left aside.

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
