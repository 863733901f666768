"""Contract of a drilling stiffness: what its file supplies.

It is one file of this folder with an object of class `Drilling`, and a line in `DRILLINGS` of
solver/package/shell/elements.py, the source of the names in descriptions and in their manual.

    stiffness(t, A, factor) -> (c, 9, 9) [N/m, N, N m]

    t       c flat triangles in their own axes E (triangles.py)
    A       (c|1, 3, 3) stretching stiffness in E [N/m]
    factor  number above 0, `drilling_factor` of the description

in the degrees of freedom (u, v, tz) of corners 1, 2, 3, tz the rotation about e3; symmetric, added
to the membrane's.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ....solver.math.arrays import Array
from ..triangles import Triangles


@dataclass(frozen=True)
class Drilling:
    """Stiffness against the rotation about the normal.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    stiffness : see above
    free_rotation : a flat part has a zero-energy motion, equal rotation of all nodes: a warning
    """

    name: str
    stiffness: Callable[[Triangles, Array, float], Array]
    free_rotation: bool = False
