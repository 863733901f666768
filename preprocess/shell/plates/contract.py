"""Contract of a plate: what its file supplies.

A plate is one file of this folder with an object of class `Plate`, and a line in `PLATES` of
solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
CONTRIBUTING.md has the recipe.

    strains(t, D, Ds) -> PlateStrains

    t    c flat triangles in their own axes E (triangles.py)
    D    (c|1, 3, 3) bending stiffness in E, of (kxx, kyy, kxy) [N m]
    Ds   (c|1, 2, 2) transverse shear stiffness, corrected, of (gxz, gyz) [N/m]

gives curvature and shear strain per unit of the nine degrees of freedom (w, bx, by) of corners
1, 2, 3 [m, rad]: w the deflection along e3, (bx, by) the rotation of the normal, u = z bx and
v = z by. A rigid motion has no strain. strains.py has the common parts of the plates.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ....solver.math.arrays import Array
from ..triangles import Triangles
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
    strains: Callable[[Triangles, Array, Array], PlateStrains]
    shear_ratio_limit: float | None = None
