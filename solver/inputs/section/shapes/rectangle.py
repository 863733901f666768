"""Solid rectangle."""

from ....package.specification import SectionMeshTable
from .contract import Plies, Shape, Values, Wall
from .parts import COUNTS, RECTANGLE, STACK, counts, faces, solid_rows, spaced


def mesh(values: Values, plies: Plies) -> SectionMeshTable:
    """Solid rectangle: rows from the top."""
    n_2, n_3 = counts(values)
    return {
        "parameters": {
            "width": values["width"],
            "height": values["height"],
            "columns": spaced(values, n_2, "width"),
            "rows": solid_rows(faces(plies["section"]), n_3, values),
        }
    }


SHAPE = Shape(
    name="rectangle",
    script="rectangle",
    meaning="solid rectangle about the origin; plies from top to bottom",
    parameters=(*RECTANGLE, *COUNTS),
    walls=(Wall("section", STACK, "height"),),
    mesh=mesh,
    order=1,
)
