"""Contract of a membrane: what its file supplies.

A membrane is one file of this folder with an object of class `Membrane`, and a line in `MEMBRANES`
of solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
CONTRIBUTING.md has the recipe.

    strains(t, A, beta0) -> MembraneStrains

    t      c flat triangles in their own axes E (triangles.py)
    A      (c|1, 3, 3) stretching stiffness in E, of (exx, eyy, gxy) [N/m]
    beta0  number, or "felippa"; of "opt" alone, others ignore it

gives strain per unit of the nine degrees of freedom (u, v, tz) of corners 1, 2, 3 [m, rad], tz the
rotation about e3, and a stiffness in addition to that of the strain. Both are zero for a rigid
motion. strains.py has the common parts of the membranes.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .strains import MembraneStrains


@dataclass(frozen=True)
class Membrane:
    """Membrane of a flat triangle.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    strains : see above
    rotations : True if it gives stiffness to tz; otherwise `drilling` does
    bow : mean distance of a side of length L from its chord is bow L/12 (tz_j - tz_i), with an
     effect on loads along the side; 0: straight sides
    stiff_in_plane : True if it is far too stiff in in-plane bending of a narrow wall: a warning
    """

    name: str
    strains: Callable[[Triangles, Array, float | str], MembraneStrains]
    rotations: bool
    bow: float = 0.0
    stiff_in_plane: bool = False
