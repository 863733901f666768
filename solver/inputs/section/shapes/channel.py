"""Channel."""

from ....package.specification import SectionMeshTable
from .contract import Plies, Shape, Values, Wall
from .parts import BOTTOM, FLANGES, ROWS, TOP, faces, flanged, half_lines, rows, united


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Channel."""
    sizes, thickness = flanged(values)
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
            **half_lines(lengths, thickness, values["density"]),
            "rows": rows(ends, ROWS, "inner", values["density"]),
        }
    }


SHAPE = Shape(
    name="channel",
    script="channel",
    meaning="channel, outer face of its web at x2 = 0, origin half way up; mitred corners",
    parameters=FLANGES,
    walls=(TOP, Wall("web", {"vector": [0.0, 1.0]}, "wall_web"), BOTTOM),
    mesh=mesh,
    order=9,
)
