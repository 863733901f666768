"""What the file of a membrane supplies.

A membrane is one file of this folder with an object of class `Membrane`, and a line in `MEMBRANES`
of solver/package/shell/elements.py: from there descriptions and their manual take the names.
CONTRIBUTING.md has the recipe.

    strains(t, A, beta0) -> MembraneStrains

    t      c flat triangles in their own axes E (triangles.py)
    A      (c|1, 3, 3) stretching stiffness in E, of (exx, eyy, gxy) [N/m]
    beta0  number, or "felippa"; of "opt" alone, others ignore it

gives strain per unit of the nine degrees of freedom (u, v, tz) of corners 1, 2, 3 [m, rad], tz the
rotation about e3, and stiffness beside that of the strain. A rigid motion has neither. strains.py
has what the membranes share.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .strains import MembraneStrains


@dataclass(frozen=True)
class Membrane:
    """Stretching of a flat triangle.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    strains : see above
    rotations : whether it gives stiffness to tz; without, `drilling` does
    bow : a side of length L leaves its chord by bow L/12 (tz_j - tz_i) on average, which loads
        along the side feel; 0: straight sides
    stiff_in_plane : far too stiff in bending of a narrow wall in its own plane: a warning
    """

    name: str
    strains: Callable[[Triangles, Array, float | str], MembraneStrains]
    rotations: bool
    bow: float = 0.0
    stiff_in_plane: bool = False
