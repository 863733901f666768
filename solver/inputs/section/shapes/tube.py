"""Circular tube, or part of one."""

import math
from typing import Any

from ....errors import InputError
from .contract import DENSITY, Parameter, Plies, Shape, Values, Wall, size
from .spacing import arc, faces, rows
from .walled import wall_thickness

STEP_DEG = 10.0  # angle of an element
# Length of an element of an open tube over sqrt(thickness x radius), the length of the bending zone
# at the ends of a thin curved wall.
BENDING = 0.4


def mesh(values: Values, plies: Plies) -> dict[str, Any]:
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


SHAPE = Shape(
    name="tube",
    script="tube",
    meaning="circular tube about the origin, or part of one",
    parameters=(
        size("outer_radius", "radius of the outer face", required=True),
        size("wall", "thickness"),
        Parameter("start_deg", "deg", "where a part begins, from x2 towards x3", 0.0),
        Parameter("span_deg", "deg", "angle of the part", 360.0, above=0.0, most=360.0),
        DENSITY,
    ),
    walls=(Wall("wall", {"circle": [0.0, 0.0]}, "wall"),),
    mesh=mesh,
    order=5,
)
