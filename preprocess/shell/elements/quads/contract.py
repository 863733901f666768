"""Contract of the plate of a quadrilateral: what its file supplies.

It is one file of this folder with an object of class `QuadPlate`, and a line in `QUADS` of
solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
The membrane (hybrid.py) is the same for all of them. The text is that of plates/contract.py.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ..cell import Cell
from ..plates import PlateStrains


@dataclass(frozen=True)
class QuadPlate:
    """Bending and transverse shear of a quadrilateral.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    strains : of its points
    internal : whether cells have rotations of their own (internal.py)
    """

    name: str
    strains: Callable[[Cell], PlateStrains]
    internal: bool = False
