"""Meshes of sections with flat walls: rows by plies, lines closer together at corners."""

import math
from typing import Any

from ....errors import InputError
from .spacing import along, faces, rows, united

Values = dict[str, Any]
Plies = dict[str, list[float]]

ROWS = 5  # of a wall at corners that has fewer plies
ROWS_WEB = 6  # of a web, with corners on both of its faces


def wall_thickness(values: Values, key: str) -> float:
    """Thickness of a wall: its own, or that of all."""
    value = values.get(key) or values.get("wall")
    if value is None:
        other = "" if key == "wall" else f" of every wall, or {key}"
        raise InputError(f"wall: missing, expected the thickness{other} [m]")
    return float(value)


def _fits(thickness: dict[str, float], keys: tuple[str, ...], space: float, what: str) -> None:
    """Raise InputError unless walls leave space between them."""
    if not math.fsum(thickness[key] for key in keys) < space:
        others = " and ".join(f"{key} = {thickness[key]:g}" for key in keys[1:])
        raise InputError(
            f"{keys[0]} = {thickness[keys[0]]:g}: expected, with {others}, less than {what}, "
            f"{space:g} [m]"
        )


def _half_lines(
    lengths: dict[str, float], thickness: dict[str, float], density: float
) -> dict[str, Any]:
    """Elements of lines between a corner and a middle: elements_*, growth_*, graded_*, even_*."""
    thinnest = min(thickness.values())
    return {
        f"{name}_{key}": value
        for key, length in lengths.items()
        for name, value in along(length, thinnest, density).items()
    }


def _box_walls(values: Values) -> dict[str, float]:
    keys = ("wall_top", "wall_right", "wall_bottom", "wall_left")
    thickness = {key: wall_thickness(values, key) for key in keys}
    _fits(thickness, ("wall_top", "wall_bottom"), values["height"], "the height")
    _fits(thickness, ("wall_left", "wall_right"), values["width"], "the width")
    return thickness


def _skin_rows(plies: Plies, density: float) -> list[float]:
    """Rows of walls that meet in mitres: the plies of all of them."""
    ends = united(faces(plies[region]) for region in ("top", "right", "bottom", "left"))
    return rows(ends, ROWS, "inner", density)


def box(values: Values, plies: Plies) -> dict[str, Any]:
    """Rectangular box."""
    thickness, density = _box_walls(values), values["density"]
    width, height = values["width"], values["height"]
    lengths = {
        "2": 0.5 * (width - thickness["wall_left"] - thickness["wall_right"]),
        "3": 0.5 * (height - thickness["wall_top"] - thickness["wall_bottom"]),
    }
    return {
        "parameters": {
            "width": width,
            "height": height,
            **thickness,
            **_half_lines(lengths, thickness, density),
            "rows": _skin_rows(plies, density),
        }
    }


def two_cell(values: Values, plies: Plies) -> dict[str, Any]:
    """Rectangular box with a web."""
    skin, density = _box_walls(values), values["density"]
    thickness = {**skin, "wall_web": wall_thickness(values, "wall_web")}
    width, height, position = values["width"], values["height"], values["web_position"]
    half = 0.5 * thickness["wall_web"]
    left = position - half - (-0.5 * width + thickness["wall_left"])
    right = 0.5 * width - thickness["wall_right"] - (position + half)
    if not min(left, right) > 0.0:
        raise InputError(
            f"web_position = {position:g}: expected a web between the side walls, with x2 from "
            f"{position - left:g} to {position + right:g} [m]"
        )
    inside = height - skin["wall_top"] - skin["wall_bottom"]
    lengths = {"left": 0.5 * left, "right": 0.5 * right, "3": 0.5 * inside}
    return {
        "parameters": {
            "width": width,
            "height": height,
            "web_position": position,
            **thickness,
            **_half_lines(lengths, thickness, density),
            "rows_skin": _skin_rows(plies, density),
            "rows_web": rows(faces(plies["web"]), ROWS_WEB, "both", density),
        }
    }


def _flanged(values: Values) -> tuple[dict[str, float], dict[str, float]]:
    """Sizes and walls of I and channel."""
    keys = ("wall_top", "wall_web", "wall_bottom")
    thickness = {key: wall_thickness(values, key) for key in keys}
    sizes = {"height": values["height"], "top_width": values["top_width"]}
    sizes["bottom_width"] = values["bottom_width"] or values["top_width"]
    _fits(thickness, ("wall_top", "wall_bottom"), sizes["height"], "the height")
    for key in ("top_width", "bottom_width"):
        if not thickness["wall_web"] < sizes[key]:
            raise InputError(
                f"wall_web = {thickness['wall_web']:g}: expected less than {key}, "
                f"{sizes[key]:g} [m]"
            )
    return sizes, thickness


def i_section(values: Values, plies: Plies) -> dict[str, Any]:
    """I section."""
    sizes, thickness = _flanged(values)
    density, web = values["density"], thickness["wall_web"]
    lengths = {
        "top": 0.25 * (sizes["top_width"] - web),
        "bottom": 0.25 * (sizes["bottom_width"] - web),
        "web": 0.5 * (sizes["height"] - thickness["wall_top"] - thickness["wall_bottom"]),
    }
    return {
        "parameters": {
            **sizes,
            **thickness,
            **_half_lines(lengths, thickness, density),
            "rows_top": rows(faces(plies["top"]), ROWS, "inner", density),
            "rows_bottom": rows(faces(plies["bottom"]), ROWS, "inner", density),
            "rows_web": rows(faces(plies["web"]), ROWS_WEB, "both", density),
        }
    }


def channel(values: Values, plies: Plies) -> dict[str, Any]:
    """Channel."""
    sizes, thickness = _flanged(values)
    lengths = {
        "top": 0.5 * (sizes["top_width"] - thickness["wall_web"]),
        "bottom": 0.5 * (sizes["bottom_width"] - thickness["wall_web"]),
        "web": 0.5 * (sizes["height"] - thickness["wall_top"] - thickness["wall_bottom"]),
    }
    ends = united(faces(plies[region]) for region in ("top", "web", "bottom"))
    return {
        "parameters": {
            **sizes,
            **thickness,
            **_half_lines(lengths, thickness, values["density"]),
            "rows": rows(ends, ROWS, "inner", values["density"]),
        }
    }
