"""Solid ellipse."""

import math

from ....package.specification import SectionMeshTable
from .contract import DENSITY, Parameter, Plies, Shape, Values, Wall, size
from .parts import STACK, count


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Solid ellipse."""
    del plies  # the mesh does not follow the plies
    radius_3 = values["radius_3"] or values["radius_2"]
    counts = {
        key: math.ceil((count(key, values[key]) or 1) * values["density"])
        for key in ("elements_arc", "elements_radial")
    }
    return {"parameters": {"radius_2": values["radius_2"], "radius_3": radius_3, **counts}}


SHAPE = Shape(
    name="ellipse",
    script="ellipse",
    meaning="solid ellipse about the origin",
    parameters=(
        size("radius_2", "half-axis along x2", required=True),
        size("radius_3", "half-axis along x3; default: radius_2"),
        Parameter("elements_arc", "-", "elements on a quarter of the edge", 10, least=1, most=1000),
        Parameter("elements_radial", "-", "elements from core to edge", 6, least=1, most=1000),
        DENSITY,
    ),
    walls=(Wall("section", STACK, "radius_3", stacked=False),),
    mesh=mesh,
    order=4,
)
