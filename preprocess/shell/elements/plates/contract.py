"""Contract of a plate: what its file supplies.

A plate is one file of this folder with an object of class `Plate`, and a line in `PLATES` of
solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
CONTRIBUTING.md has the recipe.

    strains(t) -> PlateStrains

    t    a flat triangle in its own axes E, with its laminate, in UFL (cell.py)

gives curvature and shear strain, linear in the unknowns (w, bx, by) of corners [m, rad]: w the
deflection along e3, (bx, by) the rotation of the normal, u = z bx and v = z by. A rigid motion has
no strain. strains.py has the common parts of the plates.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ..cell import Cell
from .strains import PlateStrains


@dataclass(frozen=True)
class Plate:
    """Bending and transverse shear of a flat triangle.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    strains : see above
    shear_ratio_limit : `shear_ratio` (strains.py) of a side above which the element does not
        converge: a warning; None: it always does
    """

    name: str
    strains: Callable[[Cell], PlateStrains]
    shear_ratio_limit: float | None = None
