"""Common parts of solid shapes: sizes, numbers of elements, rows by plies."""

import math
from typing import Any

from ....errors import InputError
from ....package.specification import LayerDirection
from .contract import DENSITY, Parameter, Values, size
from .spacing import both_ends, cosine

RECTANGLE = (
    size("width", "along x2", required=True),
    size("height", "along x3", required=True),
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
    """Ends of n elements along "width" or "height" as fractions of it."""
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
    """n rows, or more if every ply needs at least one."""
    if len(ends) == 1:
        return spaced(values, n, "height")
    lines = [0.0]
    for end in ends:
        start = lines[-1]
        in_ply = max(1, math.ceil((end - start) * n - 1e-9))
        lines += [start + (end - start) * i / in_ply for i in range(1, in_ply + 1)]
    return [*lines[1:-1], 1.0]
