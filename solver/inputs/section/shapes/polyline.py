"""Walls along a polyline, open or closed: angles, hats, Z and C profiles, polygons."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....errors import InputError
from ....math.arrays import Array
from ....package.specification import LayerDirection, SectionMeshTable
from .contract import DENSITY, Parameter, Plies, Shape, Values, Wall, size
from .parts import ROWS_WEB, faces, half_lines, rows, united

PARALLEL = 1e-9  # sine of the angle between neighbouring walls that need equal thicknesses


def corners(values: Mapping[str, Any]) -> tuple[Array, list[int]]:
    """Points of the middle line, (n, 2), and the number of each wall between them.

    A closed line runs clockwise, so that its outer face is on its left.
    """
    points = np.array(list(zip(values["x2"], values["x3"], strict=False)), dtype=float)
    numbers = list(range(1, len(points)))
    if len(points) > 3 and (points[0] == points[-1]).all():
        x, y = points[:-1].T, points[1:].T
        if (x[0] * y[1] - y[0] * x[1]).sum() > 0.0:
            return points[::-1], numbers[::-1]
    return points, numbers


def walls(values: Mapping[str, Any]) -> tuple[Wall, ...]:
    """Regions wall-1, wall-2, ... in the order of the points."""
    points, numbers = corners(values)
    walls_by_number = {}
    for number, way in zip(numbers, np.diff(points, axis=0), strict=True):
        direction: LayerDirection = {"vector": [float(x) for x in way]}
        walls_by_number[number] = Wall(f"wall-{number}", direction, "wall")
    return tuple(walls_by_number[number] for number in sorted(walls_by_number))


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Walls with mitred corners, in rows at the faces of the plies of all walls."""
    if len(values["x2"]) != len(values["x3"]):
        raise InputError(f"x3: {len(values['x3'])} numbers, expected {len(values['x2'])}, as in x2")
    points, numbers = corners(values)
    n = len(numbers)
    wall = values["wall"] or []
    if n < 1 or len(wall) not in (1, n):
        raise InputError(f"wall = {wall}: expected one thickness, or one for each of {n} walls")
    thickness = np.array([wall[number - 1] if len(wall) > 1 else wall[0] for number in numbers])
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if not (length > 0.0).all():
        raise InputError("x2: expected different neighbouring points")
    along = np.diff(points, axis=0) / length[:, None]
    left = np.column_stack([-along[:, 1], along[:, 0]])
    closed = n > 2 and bool((points[0] == points[-1]).all())
    column = _columns(numbers, thickness, along, left, closed)
    ends = column[:-1], column[1:]
    trim = [np.abs(np.einsum("wa,wa->w", along, end)) for end in ends]
    free = length - trim[0] - trim[1]
    for k in np.flatnonzero(free <= 0.0).tolist():
        raise InputError(
            f"wall = {wall}: wall-{numbers[k]} of length {length[k]:g} is too short for the "
            f"corners at its ends, expected more than {trim[0][k] + trim[1][k]:g} [m]"
        )
    _apart(points, numbers, thickness, closed)
    density = values["density"]
    outer, inner, elements, growth = [], [], list[float](), list[float]()
    for k in range(n):
        line = half_lines({"": 0.5 * free[k]}, {"wall": float(thickness[k])}, density)
        graded, g, m, even = (line[f"{key}_"] for key in ("graded", "growth", "elements", "even"))
        stops = [trim[0][k] + graded, trim[0][k] + 0.5 * free[k], length[k] - trim[1][k] - graded]
        middle = points[k] + np.outer(stops, along[k])
        half = 0.5 * thickness[k] * left[k]
        outer += [points[k] + column[k], *(middle + half)]
        inner += [points[k] - column[k], *(middle - half)]
        elements += [m, even, even, m]
        growth += [g, 1.0, 1.0, 1.0 / g]
    if not closed:
        outer.append(points[-1] + column[-1])
        inner.append(points[-1] - column[-1])
    return {
        "parameters": {
            **{f"outer_{k + 2}": [float(p[k]) for p in outer] for k in range(2)},
            **{f"inner_{k + 2}": [float(p[k]) for p in inner] for k in range(2)},
            "closed": float(closed),
            "elements": elements,
            "growth": growth,
            "numbers": [float(number) for number in numbers],
            "rows": rows(
                united(faces(plies[f"wall-{number}"]) for number in numbers),
                ROWS_WEB,
                "both",
                density,
            ),
        }
    }


def _columns(
    numbers: list[int], thickness: Array, along: Array, left: Array, closed: bool
) -> Array:
    """From each point to the outer face, where the faces of both walls meet, (n + 1, 2) [m]."""
    n = len(numbers)
    columns = np.empty((n + 1, 2))
    columns[0], columns[n] = 0.5 * thickness[0] * left[0], 0.5 * thickness[-1] * left[-1]
    for k in range(0 if closed else 1, n):
        pair = [k - 1, k]
        sine = along[k - 1, 0] * along[k, 1] - along[k - 1, 1] * along[k, 0]
        if abs(sine) > PARALLEL:
            columns[k] = np.linalg.solve(left[pair], 0.5 * thickness[pair])
        elif along[k - 1] @ along[k] < 0.0 or np.ptp(thickness[pair]) > PARALLEL * thickness[k]:
            raise InputError(
                f"wall-{numbers[k - 1]} and wall-{numbers[k]} are in one line: expected equal "
                "thicknesses, and no way back"
            )
        else:
            columns[k] = 0.5 * thickness[k] * left[k]
    if closed:
        columns[n] = columns[0]
    return columns


def _apart(points: Array, numbers: list[int], thickness: Array, closed: bool) -> None:
    """Raise InputError for walls that touch without a common point."""
    n = len(numbers)
    for i in range(n):
        for j in range(i + 2, n - (closed and i == 0)):
            gap = _distance(points[i : i + 2], points[j : j + 2])
            if gap <= 0.5 * (thickness[i] + thickness[j]):
                raise InputError(f"x2: wall-{numbers[i]} and wall-{numbers[j]} touch each other")


def _distance(one: Array, two: Array) -> float:
    """Distance of two line segments, each (2, 2)."""
    a, b, r = one[1] - one[0], two[1] - two[0], two[0] - one[0]
    sine = a[0] * b[1] - a[1] * b[0]
    if sine:
        s, t = (r[0] * b[1] - r[1] * b[0]) / sine, (r[0] * a[1] - r[1] * a[0]) / sine
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            return 0.0
    distances = []
    for point, start, way in (*((p, two[0], b) for p in one), *((p, one[0], a) for p in two)):
        share = np.clip((point - start) @ way / (way @ way), 0.0, 1.0)
        distances.append(float(np.linalg.norm(point - start - share * way)))
    return min(distances)


SHAPE = Shape(
    name="polyline",
    script="polyline",
    meaning="walls along a middle line through points, mitred corners; closed if the last point is "
    "the first one. The outer face of an open line is on its left, seen from the first point",
    parameters=(
        Parameter("x2", "m", "x2 of the points", required=True, many=True),
        Parameter("x3", "m", "x3 of the points", required=True, many=True),
        size("wall", "thickness of each wall, from point to point; one number: of all", many=True),
        DENSITY,
    ),
    walls=(),
    mesh=mesh,
    walls_of=walls,
    example={"x2": [0.0, 0.0, 0.1], "x3": [0.1, 0.0, 0.0]},
    order=11,
)
