"""Rectangular box."""

from ....package.specification import SectionMeshTable
from .contract import DENSITY, Plies, Shape, Values
from .parts import BOTTOM, LEFT, OUTER, RIGHT, SIDES, TOP, WALL, box_walls, half_lines, skin_rows


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Rectangular box."""
    thickness, density = box_walls(values), values["density"]
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
            **half_lines(lengths, thickness, density),
            "rows": skin_rows(plies, density),
        }
    }


SHAPE = Shape(
    name="box",
    script="box",
    meaning="rectangular box about the origin, mitred corners",
    parameters=(*OUTER, WALL, *SIDES, DENSITY),
    walls=(TOP, RIGHT, BOTTOM, LEFT),
    mesh=mesh,
    order=6,
)
