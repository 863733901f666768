"""Common parts of shapes: sizes and regions, numbers of elements, spacing of the mesh lines.

Rows lie at the faces of plies; elements are finer at corners.
"""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

from ....errors import InputError
from ....package.specification import LayerDirection
from .contract import DENSITY, Parameter, Plies, Values, Wall, size

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

    Parameters
    ----------
    length : length of the line [m]
    thickness : thickness of the wall [m]
    density : factor of the number of elements

    Returns
    -------
    elements and growth of the first part, its length `graded` [m], elements `even` of the second
    """
    growth = GROWTH ** (1.0 / density)
    longest = length / (EVEN * density)
    room = (0.5 + 1.0 / EVEN) * length  # of the first part: what it takes at most at density 1
    sizes = [min(FIRST * thickness / density, longest, room)]
    while (larger := sizes[-1] * growth) < longest and math.fsum(sizes) < 0.5 * length:
        if math.fsum(sizes) + larger > room:  # only in coarse meshes
            break
        sizes.append(larger)
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

    Parameters
    ----------
    length : length of the strip [m]
    thickness : thickness of the wall [m]
    density : factor of the number of elements
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


RECTANGLE = (
    size("width", "along x2", required=True),
    size("height", "along x3; default: that of the plies"),
)
COUNTS = (
    Parameter(
        "elements_2", "-", "elements along the width; default: by the sizes", least=1, most=1000
    ),
    Parameter(
        "elements_3", "-", "elements along the height; default: by the sizes", least=1, most=1000
    ),
    Parameter("grading", "-", "spacing, 0: equal, 1: cosine", 0.5, least=0.0, most=1.0),
    DENSITY,
)
STACK: LayerDirection = {"vector": [1.0, 0.0]}  # plies parallel to x2, the outermost on top


THIN = 99.0  # slenderness of a rectangle that is a wall
SLENDER = 50.0  # sides of more slender rectangles are graded to the thickness at their ends


def slenderness(values: Values) -> float:
    """Long over short side."""
    width, height = values["width"], values["height"]
    return float(max(width, height) / min(width, height))


def spaced(values: Values, n: int, key: str) -> list[float]:
    """Ends of n elements along "width" or "height" as fractions of it.

    Parameters
    ----------
    values : sizes of the shape
    n : number of elements
    key : "width" or "height"
    """
    sides = {"width": values["width"], "height": values["height"]}
    length = sides.pop(key)
    (across,) = sides.values()
    given = values["elements_2" if key == "width" else "elements_3"]
    if given is None and length > SLENDER * across:
        return both_ends(length, across, values["density"])
    return cosine(n, values["grading"])


def counts(values: Values) -> tuple[int, int]:
    """Numbers of elements that keep the stiffness of an off-axis ply within about 1e-4."""
    short = 10
    if values["height"] is None:
        raise InputError("height: missing; expected a value, or plies with thicknesses [m]")
    width, height = values["width"], values["height"]
    long = 2 * math.ceil(short * min(slenderness(values), SLENDER) ** 0.5 / 2)
    defaults = (long, short) if width >= height else (short, long)
    n_2, n_3 = (
        count(key, values[key]) or math.ceil(default * values["density"])
        for key, default in zip(("elements_2", "elements_3"), defaults, strict=True)
    )
    return n_2, n_3


def few_across(values: Values) -> None:
    """Set two elements across a thin rectangle of a twisted beam, if their number is not given.

    Such a wall bends without stretching. That needs a high degree along it, and no cells across.
    """
    width, height = values.get("width"), values.get("height")
    if width and height and slenderness(values) >= THIN:
        values.setdefault("elements_3" if width > height else "elements_2", 2)


def count(key: str, value: Any) -> int | None:
    """Return a number of elements; None if it is not given."""
    if value is not None and value != int(value):
        raise InputError(f"{key} = {value!r}: expected a whole number from 1")
    return None if value is None else int(value)


def solid_rows(ends: list[float], n: int, values: Values) -> list[float]:
    """n rows, or more if every ply needs at least one.

    Parameters
    ----------
    ends : ends of the plies as fractions of the height
    n : least number of rows
    values : sizes of the shape
    """
    if len(ends) == 1:
        return spaced(values, n, "height")
    lines = [0.0]
    for end in ends:
        start = lines[-1]
        in_ply = max(1, math.ceil((end - start) * n - 1e-9))
        lines += [start + (end - start) * i / in_ply for i in range(1, in_ply + 1)]
    return [*lines[1:-1], 1.0]


ROWS = 5  # least number of rows of a wall with corners
ROWS_WEB = 6  # the same of a web, which has corners on both faces
THINNEST = 1e-9  # wall over its length: longer lines of growing elements have no end


def wall(key: str, meaning: str) -> Parameter:
    """Return the thickness of one wall."""
    return size(f"wall_{key}", f"thickness of the {meaning}; default: wall")


WALL = size("wall", "thickness of every wall without its own thickness")
TOP = Wall("top", {"vector": [1.0, 0.0]}, "wall_top")
RIGHT = Wall("right", {"vector": [0.0, -1.0]}, "wall_right")
BOTTOM = Wall("bottom", {"vector": [-1.0, 0.0]}, "wall_bottom")
LEFT = Wall("left", {"vector": [0.0, 1.0]}, "wall_left")
WEB = Wall("web", {"vector": [0.0, -1.0]}, "wall_web")  # outermost ply on its right face

OUTER = (
    size("width", "outer width, along x2", required=True),
    size("height", "outer height, along x3", required=True),
)
SIDES = (
    wall("top", "top"),
    wall("right", "right side"),
    wall("bottom", "bottom"),
    wall("left", "left side"),
)
FLANGES = (
    size("height", "outer height, along x3", required=True),
    size("top_width", "width of the top flange, along x2", required=True),
    size("bottom_width", "width of the bottom flange; default: top_width"),
    WALL,
    wall("top", "top flange"),
    wall("web", "web"),
    wall("bottom", "bottom flange"),
    DENSITY,
)


def wall_thickness(values: Values, key: str) -> float:
    """Thickness of a wall: its own, or the common one."""
    value = values.get(key) or values.get("wall")
    if value is None:
        other = "" if key == "wall" else f" of every wall, or {key}"
        raise InputError(f"wall: missing, expected the thickness{other} [m]")
    return float(value)


def fits(thickness: dict[str, float], keys: tuple[str, ...], space: float, what: str) -> None:
    """Raise InputError if there is no space between walls.

    Parameters
    ----------
    thickness : thickness of the walls by key [m]
    keys : keys of the walls side by side
    space : space for them [m]
    what : what the space is, for the message
    """
    if not math.fsum(thickness[key] for key in keys) < space:
        others = " and ".join(f"{key} = {thickness[key]:g}" for key in keys[1:])
        raise InputError(
            f"{keys[0]} = {thickness[keys[0]]:g}: expected, with {others}, less than {what}, "
            f"{space:g} [m]"
        )


def half_lines(
    lengths: dict[str, float], thickness: dict[str, float], density: float
) -> dict[str, float]:
    """Elements of lines between a corner and a middle: elements_*, growth_*, graded_*, even_*.

    Parameters
    ----------
    lengths : length of each line by name [m]
    thickness : thickness of the walls by key [m]
    density : factor of the number of elements

    Raises
    ------
    InputError
        A wall that is too thin for any mesh.
    """
    wall = min(thickness, key=lambda key: thickness[key])
    thinnest, longest = thickness[wall], max(lengths.values())
    if thinnest < THINNEST * longest:
        raise InputError(
            f"{wall} = {thinnest:g}: expected at least {THINNEST:g} of the length of the walls, "
            f"{longest:g} [m]"
        )
    return {
        f"{name}_{key}": value
        for key, length in lengths.items()
        for name, value in along(length, thinnest, density).items()
    }


def box_walls(values: Values) -> dict[str, float]:
    """Thickness of the four walls of a box. Raises InputError if there is no space between them."""
    keys = ("wall_top", "wall_right", "wall_bottom", "wall_left")
    thickness = {key: wall_thickness(values, key) for key in keys}
    fits(thickness, ("wall_top", "wall_bottom"), values["height"], "the height")
    fits(thickness, ("wall_left", "wall_right"), values["width"], "the width")
    return thickness


def skin_rows(plies: Plies, density: float) -> list[float]:
    """Rows of walls with mitred corners: the plies of all walls."""
    ends = united(faces(plies[region]) for region in ("top", "right", "bottom", "left"))
    return rows(ends, ROWS, "inner", density)


def flanged(values: Values) -> tuple[dict[str, float], dict[str, float]]:
    """Sizes and walls of I and channel."""
    keys = ("wall_top", "wall_web", "wall_bottom")
    thickness = {key: wall_thickness(values, key) for key in keys}
    sizes = {"height": values["height"], "top_width": values["top_width"]}
    sizes["bottom_width"] = values["bottom_width"] or values["top_width"]
    fits(thickness, ("wall_top", "wall_bottom"), sizes["height"], "the height")
    for key in ("top_width", "bottom_width"):
        if not thickness["wall_web"] < sizes[key]:
            raise InputError(
                f"wall_web = {thickness['wall_web']:g}: expected less than {key}, "
                f"{sizes[key]:g} [m]"
            )
    return sizes, thickness
