"""Spacing of the mesh lines of a section: rows at the faces of plies, finer at corners."""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

FIRST = 1 / 12  # length of the first element at a corner over the thickness of the wall
GROWTH = 1.7  # length of an element over that of its neighbour nearer to the corner
EVEN = 4  # least number of elements in half of a wall, without those at the corner
SHRINK = 0.6  # thickness of a row at a graded face over that of the previous one
SAME = 0.01  # faces closer than this fraction of the thinnest ply are merged


def faces(plies: Sequence[float]) -> list[float]:
    """Inner faces of plies as fractions of the wall's thickness from the outer face, last 1."""
    total, depth, ends = math.fsum(plies), 0.0, []
    for ply in plies:
        depth += ply / total
        ends.append(depth)
    return [*ends[:-1], 1.0]


def united(stacks: Iterable[Sequence[float]], kept: Iterable[float] = (1.0,)) -> list[float]:
    """Faces of several walls with continuous mesh lines, ascending.

    Faces that nearly coincide are merged; the values in `kept` do not change.
    """
    stacks = list(stacks)
    thinnest = min(b - a for ends in stacks for a, b in pairwise([0.0, *ends]))
    merged = list(kept)
    for end in (end for ends in stacks for end in ends):
        if all(abs(end - other) > SAME * thinnest for other in merged):
            merged.append(end)
    return sorted(merged)


def rows(ends: Sequence[float], least: int, graded: str = "", density: float = 1.0) -> list[float]:
    """Ends of the rows of elements: one or more in each ply, at least `least` in total.

    Parameters
    ----------
    ends : inner faces of the plies, see `faces`
    least : number of rows of a wall with few plies
    graded : "inner" or "both": faces where corners concentrate stress. A wall of few plies gets its
     additional rows there, thinner towards the face; "": none
    density : of the elements, over the default
    """
    least = max(1, round(least * density))
    shares = [b - a for a, b in pairwise([0.0, *ends])]
    # thick plies among thin ones are divided too
    counts = [
        max(1, round(density), math.ceil(share * least / (2 if graded else 1) - 1e-9))
        for share in shares
    ]
    missing = max(0, least - sum(counts))
    shrink = SHRINK ** (1.0 / density)
    lines = [0.0]
    for i, (count, end) in enumerate(zip(counts, ends, strict=True)):
        first, last = graded == "both" and i == 0, bool(graded) and i == len(ends) - 1
        if first and last:
            half = graded_ends(math.ceil(0.5 * (count + missing)), shrink)
            inside = [0.5 - 0.5 * x for x in reversed(half[:-1])] + [0.5 + 0.5 * x for x in half]
            inside = sorted({*inside, 0.5})
        elif last:
            extra = missing if graded == "inner" else math.ceil(0.5 * missing)
            inside = graded_ends(count + extra, shrink)
        elif first:
            towards_face = graded_ends(count + math.ceil(0.5 * missing), shrink)
            inside = [1.0 - x for x in reversed(towards_face[:-1])] + [1.0]
        else:
            inside = [(k + 1) / count for k in range(count)]
        start = lines[-1]
        lines += [start + (end - start) * x for x in inside]
    return [*lines[1:-1], 1.0]


def graded_ends(n: int, ratio: float) -> list[float]:
    """Ends of n elements from 0 to 1; each is `ratio` times as long as the previous one."""
    sizes = [ratio**i for i in range(n)]
    return [math.fsum(sizes[: i + 1]) / math.fsum(sizes) for i in range(n)]


def along(length: float, thickness: float, density: float = 1.0) -> dict[str, float]:
    """Elements along a line from a corner to the middle of a wall.

    They grow with the distance from the corner, then they are equal. Thin laminated walls bend
    between their corners; longer elements would not resolve this.

    Returns
    -------
    elements and growth of the first part, its length `graded` [m], elements `even` of the second
    """
    growth = GROWTH ** (1.0 / density)
    longest = length / (EVEN * density)
    sizes = [min(FIRST * thickness / density, longest)]
    while sizes[-1] * growth < longest and math.fsum(sizes) < 0.5 * length:
        sizes.append(sizes[-1] * growth)
    graded = math.fsum(sizes)
    return {
        "elements": len(sizes),
        "growth": growth,
        "graded": graded,
        "even": max(1, math.ceil((length - graded) / longest - 1e-9)),
    }


def both_ends(length: float, thickness: float, density: float = 1.0) -> list[float]:
    """Ends of the elements of a strip from 0 to 1, graded to the thickness at both ends.

    The stresses of torsion and shear change there within one thickness.
    """
    line = along(0.5 * length, thickness, density)
    first, even = int(line["elements"]), int(line["even"])
    sizes = [line["growth"] ** i for i in range(first)]
    sizes += [math.fsum(sizes) * (0.5 * length / line["graded"] - 1.0) / even] * even
    half = [math.fsum(sizes[: i + 1]) / math.fsum(sizes) for i in range(len(sizes))]
    return [0.5 * x for x in half] + [1.0 - 0.5 * x for x in reversed(half[:-1])] + [1.0]


def cosine(n: int, grading: float) -> list[float]:
    """Ends of n elements from 0 to 1: equal (grading 0) to cosine spacing (1)."""
    return [
        (1.0 - grading) * i / n + grading * 0.5 * (1.0 - math.cos(math.pi * i / n))
        for i in range(1, n)
    ] + [1.0]


def arc(span: float, step: float, first: float) -> dict[str, list[float]]:
    """Patches of an open arc: finer towards both ends, equal between.

    Parameters
    ----------
    span : angle of the arc
    step : angle of an element far from the ends
    first : angle of an element at an end

    Returns
    -------
    patches (their ends as fractions of the span), elements and growth of each
    """
    sizes = [min(first, step)]
    while sizes[-1] * GROWTH < step and math.fsum(sizes) < 0.25 * span:
        sizes.append(sizes[-1] * GROWTH)
    end = math.fsum(sizes) / span
    even = max(1, math.ceil((0.5 - end) * span / step - 1e-9))
    return {
        "patches": [end, 0.5, 1.0 - end, 1.0],
        "elements": [len(sizes), even, even, len(sizes)],
        "growth": [GROWTH, 1.0, 1.0, 1.0 / GROWTH],
    }
