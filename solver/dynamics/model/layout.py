"""Structure of a mechanism, computed once: rows and columns that the step loop uses.

Every body has one dense block of M and of the Jacobian. Three kinds of rows join the blocks:

- constraints, numbered as the joints give them;
- added inertia: one row for every direction in which a body has no inertia of its own
  (added_inertia.py);
- rows of force elements (forces/contract.py), which only the Newton matrices of the implicit
  integrators have.

At a body, columns of the Jacobian stand in the same order.

`order` chooses the order in which rows are eliminated, so that the profile below the diagonal
stays narrow. Bodies are eliminated first, one by one; what is left is a symmetric matrix of the
rows, in which two joints meet only if they share a body. Elimination in the profile then costs
linear in the number of bodies of a chain, little more for a tree of limited branching.

Rows stand in groups: those of a joint, of a force element, of a body's added inertia. Constraints
come before all other rows at their bodies: a stiff spring beside a joint must not look as if it
made the joint's rows depend on each other.
"""

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import IntArray, distinct
from ...math.compiled import structure


@structure
class RowOrder(NamedTuple):
    """Rows of one elimination, in their order; see `Layout` for the numbers of rows and columns."""

    most_rows: int  # rows at the busiest body
    free_start: IntArray  # (nb + 1,) first entry of each body in the next two
    free_column: IntArray  # rows at a body that do not drive its frame: their number there
    free_place: IntArray  # and their place in the order of elimination, ascending at a body
    place: IntArray  # (n_r,) place of each row in the order of elimination; -1: it drives a frame
    first: IntArray  # (n_p,) first column of each place in the profile
    profile_start: IntArray  # (n_p + 1,) of the rows of the profile
    constraint: IntArray  # (n_p,) 1: the row of a constraint, 0: of an element or of added inertia


def row_order(
    bodies: IntArray,
    row: IntArray,
    free: NDArray[np.bool_],
    n_joint: int,
    at_body: Sequence[Sequence[int]],
) -> RowOrder:
    """Return the order of the rows of some groups.

    Parameters
    ----------
    bodies : (n_g, 2 or more) bodies of each group, -1 for the ground or none; joints come first
    row : (n_g + 1,) first row of each group
    free : (n_g,) False: rows that drive a frame and are not eliminated
    n_joint : groups that are joints
    at_body : rows at each body, column by column
    """
    groups = tuple(map(tuple, bodies.tolist())), tuple(row.tolist()), tuple(free.tolist())
    return _row_order(*groups, n_joint, tuple(map(tuple, at_body)))


@lru_cache(maxsize=16)  # the members of a sweep have the same joints
def _row_order(
    sides: tuple[tuple[int, ...], ...],
    rows: tuple[int, ...],
    used: tuple[bool, ...],
    n_joint: int,
    at_body: tuple[tuple[int, ...], ...],
) -> RowOrder:
    bodies = padded(sides)
    row, free = np.array(rows, dtype=np.int64), np.array(used, dtype=bool)
    counts = np.diff(row)
    compact = _places(bodies[free], starts(counts[free].tolist()), int(np.sum(free[:n_joint])))
    place = np.full(int(row[-1]), -1, dtype=np.int64)
    place[np.repeat(free, counts)] = compact
    first = _first_columns(bodies[free], starts(counts[free].tolist()), compact)
    constraint = np.zeros(first.size, dtype=np.int64)
    held = place[: row[n_joint]]
    constraint[held[held >= 0]] = 1
    columns = [
        sorted((p for p, r in enumerate(rows) if place[r] >= 0), key=lambda p: place[rows[p]])
        for rows in at_body
    ]
    return RowOrder(
        most_rows=max((len(rows) for rows in at_body), default=0),
        free_start=starts([len(p) for p in columns]),
        free_column=joined(columns),
        free_place=place[picked(at_body, columns)],
        place=place,
        first=first,
        profile_start=starts((np.arange(first.size) - first + 1).tolist()),
        constraint=constraint,
    )


def padded(lists: Sequence[Sequence[int]]) -> IntArray:
    """Return lists of bodies as rows (n, 2 or more), with -1 for none."""
    width = max([2, *(len(one) for one in lists)])
    rows = [[*one, *[-1] * (width - len(one))] for one in lists]
    return np.array(rows, dtype=np.int64).reshape(-1, width)


def joined(lists: Sequence[Sequence[int]]) -> IntArray:
    """Return the numbers of all lists in one array."""
    return np.array([value for one in lists for value in one], dtype=np.int64)


def picked(lists: Sequence[Sequence[int]], numbers: Sequence[Sequence[int]]) -> IntArray:
    """Return of each list the entries of the given numbers, all in one array."""
    return joined([[one[p] for p in n] for one, n in zip(lists, numbers, strict=True)])


def starts(sizes: Sequence[int]) -> IntArray:
    """Return the first entry of each of several pieces laid end to end, and the end."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _places(bodies: IntArray, row: IntArray, n_joint: int) -> IntArray:
    """Return the place of each row: groups that share bodies stand close together.

    Of two orders the cheaper one: the narrow one serves chains and rings, leaves first serves
    trees, whose breadth makes every narrow order wide.
    """
    if len(bodies) == 0:
        return np.zeros(0, dtype=np.int64)
    choice = [
        _rows_in_order(_constraints_first(order, bodies, n_joint), row)
        for order in (_narrow(bodies), _leaves_first(bodies))
    ]
    costs = [_cost(_first_columns(bodies, row, place)) for place in choice]
    return choice[int(np.argmin(costs))]


def _constraints_first(order: Sequence[int], bodies: IntArray, n_joint: int) -> list[int]:
    """Return the order with all other groups after the joints at their bodies."""
    position = {k: n for n, k in enumerate(order)}
    last: dict[int, int] = {}
    for k in range(n_joint):
        for body in bodies[k].tolist():
            last[body] = max(last.get(body, -1), position[k])
    last.pop(-1, None)

    def key(k: int) -> tuple[int, int, int]:
        if k < n_joint:
            return position[k], 0, 0
        after = [last[body] for body in bodies[k].tolist() if body in last]
        return max(after, default=position[k]), 1, position[k]

    return sorted(order, key=key)


def _rows_in_order(order: Sequence[int], row: IntArray) -> IntArray:
    """Return the place of each row, with the groups in a given order."""
    place = np.empty(int(row[-1]), dtype=np.int64)
    n = 0
    for k in order:
        rows = np.arange(row[k], row[k + 1])
        place[rows] = n + np.arange(rows.size)
        n += rows.size
    return place


def _first_columns(bodies: IntArray, row: IntArray, place: IntArray) -> IntArray:
    """Return the first column of each place: that of the first row at the same bodies."""
    begin = place[row[:-1]]
    least = np.full(int(bodies.max(initial=-1)) + 2, place.size)  # the last one is the ground's
    for side in range(bodies.shape[1]):
        np.minimum.at(least, bodies[:, side], begin)
    least[-1] = place.size
    first = np.empty(place.size, dtype=np.int64)
    first[place] = np.repeat(np.minimum(least[bodies].min(axis=1), begin), np.diff(row))
    return first


def _cost(first: IntArray) -> int:
    """Return the number of multiplications that elimination in a profile takes."""
    column = np.arange(first.size)
    return sum(
        int((column[begin:row] - np.maximum(first[begin:row], begin)).sum() + row - begin)
        for row, begin in enumerate(first)
    )


def _narrow(bodies: IntArray) -> list[int]:
    """Return the order of joints by Cuthill and McKee, reversed: joints that share a body meet.

    Breadth first from the joint with the fewest neighbours, these in ascending order of their own
    neighbours.
    """
    pairs = [tuple({body for body in pair if body >= 0}) for pair in bodies.tolist()]
    at_body: dict[int, list[int]] = {}
    for k, pair in enumerate(pairs):
        for body in pair:
            at_body.setdefault(body, []).append(k)
    # A joint beside another between the same bodies is met twice.
    same = Counter(tuple(sorted(pair)) for pair in pairs if len(pair) == 2)
    degree = [
        sum(len(at_body[body]) for body in pair) - same.get(tuple(sorted(pair)), 0)
        for pair in pairs
    ]
    order: list[int] = []
    seen, expanded = [False] * len(pairs), set()
    for root in sorted(range(len(pairs)), key=degree.__getitem__):
        if seen[root]:
            continue
        seen[root] = True
        line = [root]
        for k in line:
            new: list[int] = []
            for body in pairs[k]:
                if body not in expanded:
                    expanded.add(body)
                    new += [other for other in at_body[body] if not seen[other]]
                    for other in at_body[body]:
                        seen[other] = True
            line += sorted(new, key=degree.__getitem__)
        order += line
    return order[::-1]


def _leaves_first(bodies: IntArray) -> list[int]:
    """Return the order of joints in which all that hangs on a body comes before what holds it.

    Of several branches the largest comes first: the joints that follow reach back over the
    others only, for a tree of n bodies over n log n places in all.
    """
    ground = int(bodies.max()) + 1
    at_body: list[list[tuple[int, int]]] = [[] for _ in range(ground + 1)]
    for k, pair in enumerate(np.where(bodies < 0, ground, bodies)[:, :2].tolist()):
        at_body[pair[0]].append((k, pair[1]))
        at_body[pair[1]].append((k, pair[0]))
    holder: dict[int, int] = {}  # body -> joint by which it hangs
    branches: list[list[int]] = [[] for _ in range(ground + 1)]
    size = [0] * (ground + 1)
    roots, reached = [], [False] * (ground + 1)
    for root in (ground, *range(ground)):
        if reached[root]:
            continue
        roots.append(root)
        reached[root], line = True, [root]
        for body in line:
            for k, other in at_body[body]:
                if not reached[other]:
                    reached[other], holder[other] = True, k
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
        # joints that close a loop stand before the one by which the body hangs
        order.update((k, None) for k, _ in at_body[body] if k not in holding and k not in order)
        if body in holder:
            order[holder[body]] = None
    return list(order)


@structure
class Layout(NamedTuple):
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
    mass: RowOrder  # rows of the mass matrix: constraints and added inertia
    newton: RowOrder  # rows of Newton's matrix: the same, and those of force elements


def make_layout(
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
) -> Layout:
    """Return the layout of a mechanism; arguments as in `Model`.

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
    used = distinct(np.concatenate(standing).astype(np.int64))
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
    for k, element in enumerate(element_rows):
        if not len(element):
            continue
        for side in range(2):
            if at_ends[k, side] >= 0:
                rows = at_body[at_ends[k, side]]
                element_side[k, side] = len(rows)
                rows.extend(range(row[-1], row[-1] + len(element)))
        groups.append(at_ends[k].tolist())
        row.append(row[-1] + len(element))
    newton = _order(groups, row, driven, at_body)

    drives = [[p for p, r in enumerate(rows) if mass.place[r] < 0] for rows in constraint_rows]
    lead = np.where(np.array(uncoupled, dtype=bool), 6, 6 + n_mode) if uncoupled else 6 + n_mode
    base = np.zeros(nb, dtype=np.int64)
    base[driven[driven >= 0]] = 6
    return Layout(
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
        element_start=starts([len(element) for element in element_rows]),
        element_row=joined(element_rows),
        coupling_column=np.array(columns, dtype=np.int64).reshape(-1, 2),
        element_side=element_side,
        most_element_rows=most_element_rows,
        mass=mass,
        newton=newton,
    )


def _order(
    groups: list[list[int]], row: list[int], driven: IntArray, at_body: list[list[int]]
) -> RowOrder:
    free = np.ones(len(groups), dtype=bool)
    free[: driven.size] = driven < 0
    return row_order(padded(groups), np.array(row, dtype=np.int64), free, driven.size, at_body)
