"""Meshes of solid sections and tubes: rows by plies, counts of elements."""

import math
from typing import Any

from ....errors import InputError
from .spacing import arc, cosine, faces, rows, united
from .walls import wall_thickness

Values = dict[str, Any]
Plies = dict[str, list[float]]

STEP_DEG = 10.0  # angle of an element of a tube
# Length of an element of an open tube over sqrt(thickness x radius): a thin curved wall bends
# within that length at its ends.
BENDING = 0.4


def rectangle(values: Values, plies: Plies) -> dict[str, Any]:
    """Solid rectangle: rows from the top."""
    n_2, n_3 = _counts(values)
    return {
        "parameters": {
            "width": values["width"],
            "height": values["height"],
            "columns": cosine(n_2, values["grading"]),
            "rows": _solid_rows(faces(plies["section"]), n_3, values["grading"]),
        }
    }


def split_rectangle(values: Values, plies: Plies) -> dict[str, Any]:
    """Two solid rectangles side by side."""
    width, interface = values["width"], values["interface"]
    if not abs(interface) < 0.5 * width:
        raise InputError(
            f"interface = {interface:g}: expected inside the width, from {-0.5 * width:g} to "
            f"{0.5 * width:g} [m]"
        )
    n_2, n_3 = _counts(values)
    columns = cosine(math.ceil(0.75 * n_2), max(values["grading"], 0.75))
    return {
        "parameters": {
            "width": width,
            "height": values["height"],
            "interface": interface,
            "columns_left": columns,
            "columns_right": columns,
            "rows": _solid_rows(
                united([faces(plies["left"]), faces(plies["right"])]), n_3, values["grading"]
            ),
        }
    }


def _counts(values: Values) -> tuple[int, int]:
    """Numbers of elements that keep the stiffness of an off-axis ply within about 1e-4."""
    short = 10
    width, height = values["width"], values["height"]
    slenderness = max(width, height) / min(width, height)
    long = 2 * math.ceil(short * min(slenderness, 50.0) ** 0.5 / 2)
    defaults = (long, short) if width >= height else (short, long)
    n_2, n_3 = (
        _count(key, values[key]) or math.ceil(default * values["density"])
        for key, default in zip(("elements_2", "elements_3"), defaults, strict=True)
    )
    return n_2, n_3


def _count(key: str, value: Any) -> int | None:
    if value is not None and value != int(value):
        raise InputError(f"{key} = {value!r}: expected a whole number from 1")
    return None if value is None else int(value)


def _solid_rows(ends: list[float], n: int, grading: float) -> list[float]:
    """n rows, or as many as it takes to give every ply at least one."""
    if len(ends) == 1:
        return cosine(n, grading)
    lines = [0.0]
    for end in ends:
        start = lines[-1]
        in_ply = max(1, math.ceil((end - start) * n - 1e-9))
        lines += [start + (end - start) * i / in_ply for i in range(1, in_ply + 1)]
    return [*lines[1:-1], 1.0]


def ellipse(values: Values, plies: Plies) -> dict[str, Any]:
    """Solid ellipse."""
    del plies  # they do not follow the mesh
    radius_3 = values["radius_3"] or values["radius_2"]
    counts = {
        key: math.ceil((_count(key, values[key]) or 1) * values["density"])
        for key in ("elements_arc", "elements_radial")
    }
    return {"parameters": {"radius_2": values["radius_2"], "radius_3": radius_3, **counts}}


def tube(values: Values, plies: Plies) -> dict[str, Any]:
    """Tube or part of one."""
    radius, wall = values["outer_radius"], wall_thickness(values, "wall")
    if not wall < radius:
        raise InputError(
            f"wall = {wall:g}: expected below the outer radius, {radius:g} [m]; a solid disc is "
            "an ellipse"
        )
    span, density = values["span_deg"], values["density"]
    step = STEP_DEG / density
    if span == 360.0:
        quarter = math.ceil(90.0 / step)
        columns = {
            "patches": [0.25, 0.5, 0.75, 1.0],
            "elements": [quarter] * 4,
            "growth": [1.0] * 4,
        }
    else:
        first = math.degrees(wall / (4.0 * density * radius))
        bending = math.degrees(BENDING * math.sqrt(wall / radius)) / density
        columns = arc(span, min(step, bending, span / 6.0), first)
    # thick walls need rows for the curvature, laminates for the plies
    least = max(2, math.ceil(8.0 * wall / radius))
    return {
        "parameters": {
            "outer_radius": radius,
            "wall": wall,
            "start_deg": values["start_deg"],
            "span_deg": span,
            **columns,
            "rows": rows(faces(plies["wall"]), least, density=density),
        }
    }
