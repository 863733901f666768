"""Contract of a drilling stiffness: what its file supplies.

It is one file of this folder with an object of class `Drilling`, and a line in `DRILLINGS` of
solver/package/shell/elements.py, the source of the names in descriptions and in their manual.

    pairs(t) -> [(stress, strain), ..]

    t    a flat triangle in its own axes E, with its laminate, in UFL (cell.py); t.drilling_factor
         is the number above 0 of the description

vectors whose product is the work of the whole triangle, linear in the unknowns (u, v, tz) of
corners, tz the rotation about e3; added to the membrane's.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..cell import Cell


@dataclass(frozen=True)
class Drilling:
    """Stiffness against the rotation about the normal.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    pairs : see above
    free_rotation : a flat part has a zero-energy motion, equal rotation of all nodes: a warning
    """

    name: str
    pairs: Callable[[Cell], list[tuple[Any, Any]]]
    free_rotation: bool = False
