"""Two solid rectangles side by side."""

import math

from ....errors import InputError
from ....package.specification import SectionMeshTable
from .contract import Parameter, Plies, Shape, Values, Wall
from .parts import COUNTS, RECTANGLE, STACK, cosine, counts, faces, solid_rows, united


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Two solid rectangles side by side."""
    width, interface = values["width"], values["interface"]
    if not abs(interface) < 0.5 * width:
        raise InputError(
            f"interface = {interface:g}: expected inside the width, from {-0.5 * width:g} to "
            f"{0.5 * width:g} [m]"
        )
    n_2, n_3 = counts(values)
    columns = cosine(math.ceil(0.75 * n_2), max(values["grading"], 0.75))
    return {
        "parameters": {
            "width": width,
            "height": values["height"],
            "interface": interface,
            "columns_left": columns,
            "columns_right": columns,
            "rows": solid_rows(united([faces(plies["left"]), faces(plies["right"])]), n_3, values),
        }
    }


SHAPE = Shape(
    name="split-rectangle",
    script="split-rectangle",
    meaning="rectangle of two materials side by side; plies from top to bottom",
    parameters=(
        *RECTANGLE,
        Parameter("interface", "m", "x2 where left and right meet", 0.0),
        *COUNTS,
    ),
    walls=(Wall("left", STACK, "height"), Wall("right", STACK, "height")),
    mesh=mesh,
    order=3,
)
