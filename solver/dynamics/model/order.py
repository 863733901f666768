"""The order in which rows are eliminated, so that the profile below the diagonal stays narrow.

Bodies are eliminated first, one by one; what is left is a symmetric matrix of the rows, in which
two joints meet only if they share a body. Elimination in the profile then costs linear in the
number of bodies of a chain, little more for a tree of limited branching.

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

from ...math.arrays import IntArray
from ...math.compiled import structure


@structure
class Order(NamedTuple):
    """Rows of one elimination, in their order; see `Plan` for the numbers of rows and columns."""

    most_rows: int  # rows at the busiest body
    free_start: IntArray  # (nb + 1,) first entry of each body in the next two
    free_column: IntArray  # rows at a body that do not drive its frame: their number there
    free_place: IntArray  # and their place in the order of elimination
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
) -> Order:
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
) -> Order:
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
    columns = [[p for p, r in enumerate(rows) if place[r] >= 0] for rows in at_body]
    return Order(
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
        # joints that close a loop stand before the one by which the body hangs
        order.update((k, None) for k, _ in at_body[body] if k not in holding and k not in order)
        if body in holder:
            order[holder[body]] = None
    return list(order)
