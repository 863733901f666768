"""I section."""

from ....package.specification import SectionMeshTable
from .contract import Plies, Shape, Values
from .parts import BOTTOM, FLANGES, ROWS, ROWS_WEB, TOP, WEB, faces, flanged, half_lines, rows


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """I section."""
    sizes, thickness = flanged(values)
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
            **half_lines(lengths, thickness, density),
            "rows_top": rows(faces(plies["top"]), ROWS, "inner", density),
            "rows_bottom": rows(faces(plies["bottom"]), ROWS, "inner", density),
            "rows_web": rows(faces(plies["web"]), ROWS_WEB, "both", density),
        }
    }


SHAPE = Shape(
    name="i",
    script="i",
    meaning="I section, its web on the x3 axis, origin half way up; sharp corners",
    parameters=FLANGES,
    walls=(TOP, WEB, BOTTOM),
    mesh=mesh,
    order=8,
)
