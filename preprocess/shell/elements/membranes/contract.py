"""Contract of a membrane: what its file supplies.

A membrane is one file of this folder with an object of class `Membrane`, and a line in `MEMBRANES`
of solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
CONTRIBUTING.md has the recipe.

    strains(t) -> MembraneStrains

    t    a flat triangle in its own axes E, with its laminate, in UFL (cell.py)

gives strain, linear in the unknowns (u, v, tz) of corners [m, rad], tz the rotation about e3, and
pairs of stiffness in addition to that of the strain. Both are zero for a rigid motion. strains.py
has the common parts of the membranes.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ..cell import Cell
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
    strains: Callable[[Cell], MembraneStrains]
    rotations: bool
    bow: float = 0.0
    stiff_in_plane: bool = False
