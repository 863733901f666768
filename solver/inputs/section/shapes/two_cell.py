"""Rectangular box with a web."""

from ....errors import InputError
from ....package.specification import SectionMeshTable
from .contract import DENSITY, Parameter, Plies, Shape, Values
from .parts import (
    BOTTOM,
    LEFT,
    OUTER,
    RIGHT,
    ROWS_WEB,
    SIDES,
    TOP,
    WALL,
    WEB,
    box_walls,
    faces,
    half_lines,
    rows,
    skin_rows,
    wall,
    wall_thickness,
)


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Rectangular box with a web."""
    skin, density = box_walls(values), values["density"]
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
            **half_lines(lengths, thickness, density),
            "rows_skin": skin_rows(plies, density),
            "rows_web": rows(faces(plies["web"]), ROWS_WEB, "both", density),
        }
    }


SHAPE = Shape(
    name="two-cell",
    script="two-cell",
    meaning="rectangular box about the origin with a web between top and bottom, mitred corners",
    parameters=(
        *OUTER,
        Parameter("web_position", "m", "x2 of the web's middle", 0.0),
        WALL,
        *SIDES,
        wall("web", "web"),
        DENSITY,
    ),
    walls=(TOP, RIGHT, BOTTOM, LEFT, WEB),
    mesh=mesh,
    order=7,
)
