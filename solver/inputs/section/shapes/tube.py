"""Circular tube, or part of one."""

import math

from ....errors import InputError
from ....package.specification import SectionMeshTable
from .contract import DENSITY, Parameter, Plies, Shape, Values, Wall, size
from .parts import arc, faces, rows, wall_thickness

STEP_DEG = 10.0  # angle of an element
# Length of an element of an open tube over sqrt(thickness x radius), the length of the bending zone
# at the ends of a thin curved wall.
BENDING = 0.4
# Largest distance between a parabolic edge and its circle, over the thickness of the thinnest ply:
# points near the face of a ply must not count to its neighbour.
ON_CIRCLE = 0.02


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Tube or part of one."""
    radius, wall = values["outer_radius"], wall_thickness(values, "wall")
    if not wall < radius:
        raise InputError(
            f"wall = {wall:g}: expected below the outer radius, {radius:g} [m]; a solid disc is "
            "an ellipse"
        )
    span, density = values["span_deg"], values["density"]
    step = _step(plies["wall"], wall / radius) / density
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


def _step(plies: list[float], wall: float) -> float:
    """Angle of an element [deg] whose edges are close to circles, for a wall over the radius.

    The distance of the edges from circles is (1 - cos phi)^2 / 8 for an angle of 2 phi.
    """
    if len(plies) < 2:
        return STEP_DEG
    thinnest = wall * min(plies) / math.fsum(plies)
    rise = min(math.sqrt(8.0 * ON_CIRCLE * thinnest), 1.0)
    return min(STEP_DEG, math.degrees(2.0 * math.acos(1.0 - rise)))


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
