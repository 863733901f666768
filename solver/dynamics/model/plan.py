"""Structure of a mechanism, computed once: rows and columns that the step loop uses.

Every body has one dense block of M and of the Jacobian. Three kinds of rows join the blocks:

- constraints, numbered as the joints give them;
- added inertia: one row for every direction in which a body has no inertia of its own
  (bodies/added_inertia.py);
- rows of force elements (forces/contract.py), which only the Newton matrices of the implicit
  integrators have.

At a body, columns of the Jacobian stand in the same order.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...math.arrays import IntArray
from ...math.compiled import structure
from .order import Order, joined, padded, picked, row_order, starts


@structure
class Plan(NamedTuple):
    """Integers that follow from bodies, markers, joints and force elements alone."""

    widest: int  # coordinates of the largest body
    most_modes: int
    marker_used: IntArray  # markers on bodies that joints, force elements and expressions use
    size: IntArray  # (nb,) coordinates of each body
    lead: IntArray  # (nb,) a mode is coupled with so many leading coordinates: 6, or all of them
    base: IntArray  # (nb,) first coordinate that is eliminated: 6 where the frame is driven
    row_start: IntArray  # (nb + 1,) first entry of each body in body_row
    body_row: IntArray  # every constraint row at a body
    side_row: IntArray  # (nj, 2) first row of a joint's side among the rows at its body; -1: ground
    driven_start: IntArray  # (nb + 1,) first entry of each body in the next two
    driven_column: IntArray  # the six rows that drive a frame: their number at the body
    driven_row: IntArray  # and among all rows
    added_start: IntArray  # (nb + 1,) first direction of added inertia of each body
    element_start: IntArray  # (nf + 1,) first entry of each force element in element_row
    element_row: IntArray  # which of the rows that its kind can have
    coupling_column: IntArray  # (n_term, 2) row of a coupling among those at the bodies of a term
    element_side: IntArray  # (nf, 2) first of them among the rows at a body; -1: ground or none
    most_element_rows: int  # rows that a kind of force element can have
    mass: Order  # rows of the mass matrix: constraints and added inertia
    newton: Order  # rows of Newton's matrix: the same, and those of force elements


def make_plan(
    n_mode: IntArray,
    marker_body: IntArray,
    joint_marker: IntArray,
    joint_row: IntArray,
    force_marker: IntArray,
    *,
    uncoupled: Sequence[bool] = (),
    driven: IntArray | None = None,
    added: Sequence[int] = (),
    element_rows: Sequence[Sequence[int]] = (),
    most_element_rows: int = 0,
    measured: Sequence[int] = (),
    couplings: Sequence[Sequence[int]] = (),
) -> Plan:
    """Return the plan of a mechanism; arguments as in `Model`.

    Parameters
    ----------
    uncoupled : by body, whether its modes have diagonal mass, stiffness and damping; none if empty
    driven : (nj,) the body whose frame a joint drives, alone or with others (assembly.py); -1: none
    added : by body, directions of added inertia; none if empty
    element_rows : by force element, its rows in Newton's matrix; none if empty
    most_element_rows : of any kind of force element
    measured : markers whose motion expressions read
    couplings : by coupling, the last ones of the joints, the two markers of each coordinate
    """
    nb, nj, nf = n_mode.size, joint_row.size - 1, len(force_marker)
    standing = (joint_marker.ravel(), force_marker.ravel(), np.array(measured))
    used = np.unique(np.concatenate(standing).astype(np.int64))
    bodies = marker_body[joint_marker].reshape(nj, 2)
    at_ends = marker_body[force_marker].reshape(nf, 2)
    driven = np.full(nj, -1) if driven is None else driven
    side_row = np.full((nj, 2), -1, dtype=np.int64)
    at_body: list[list[int]] = [[] for _ in range(nb)]
    n_plain = nj - len(couplings)
    for k in range(n_plain):
        for side in range(2):
            if bodies[k, side] >= 0:
                rows = at_body[bodies[k, side]]
                side_row[k, side] = len(rows)
                rows.extend(range(joint_row[k], joint_row[k + 1]))
    coupled, columns = [], []
    for k, ends in enumerate(couplings, start=n_plain):
        column = {}
        for body in dict.fromkeys(marker_body[list(ends)].tolist()):
            if body >= 0:
                column[body] = len(at_body[body])
                at_body[body].append(int(joint_row[k]))
        columns += [column.get(body, -1) for body in marker_body[list(ends)].tolist()]
        coupled.append(list(column))
    constraint_rows = [list(rows) for rows in at_body]

    # groups of rows: joints, added inertia of one body each, force elements
    groups, row = [*bodies[:n_plain].tolist(), *coupled], joint_row.tolist()
    added = list(added) or [0] * nb
    for i, count in enumerate(added):
        if count:
            groups.append([i, -1])
            at_body[i].extend(range(row[-1], row[-1] + count))
            row.append(row[-1] + count)
    mass = _order(groups, row, driven, at_body)

    element_rows = list(element_rows) or [()] * nf
    element_side = np.full((nf, 2), -1, dtype=np.int64)
    for k, found in enumerate(element_rows):
        if not len(found):
            continue
        for side in range(2):
            if at_ends[k, side] >= 0:
                rows = at_body[at_ends[k, side]]
                element_side[k, side] = len(rows)
                rows.extend(range(row[-1], row[-1] + len(found)))
        groups.append(at_ends[k].tolist())
        row.append(row[-1] + len(found))
    newton = _order(groups, row, driven, at_body)

    drives = [[p for p, r in enumerate(rows) if mass.place[r] < 0] for rows in constraint_rows]
    lead = np.where(np.array(uncoupled, dtype=bool), 6, 6 + n_mode) if uncoupled else 6 + n_mode
    base = np.zeros(nb, dtype=np.int64)
    base[driven[driven >= 0]] = 6
    return Plan(
        widest=int((6 + n_mode).max(initial=6)),
        most_modes=int(n_mode.max(initial=0)),
        marker_used=used[marker_body[used] >= 0] if used.size else used,
        size=6 + n_mode,
        lead=lead.astype(np.int64),
        base=base,
        row_start=starts([len(rows) for rows in constraint_rows]),
        body_row=joined(constraint_rows),
        side_row=side_row,
        driven_start=starts([len(p) for p in drives]),
        driven_column=joined(drives),
        driven_row=picked(constraint_rows, drives),
        added_start=starts(added),
        element_start=starts([len(found) for found in element_rows]),
        element_row=joined(element_rows),
        coupling_column=np.array(columns, dtype=np.int64).reshape(-1, 2),
        element_side=element_side,
        most_element_rows=most_element_rows,
        mass=mass,
        newton=newton,
    )


def _order(
    groups: list[list[int]], row: list[int], driven: IntArray, at_body: list[list[int]]
) -> Order:
    free = np.ones(len(groups), dtype=bool)
    free[: driven.size] = driven < 0
    return row_order(padded(groups), np.array(row, dtype=np.int64), free, driven.size, at_body)
