"""Plate elements (flat triangles): one file per element, all with the same interface.

    f(t: Triangles, D (c|1, 3, 3) [N m], Ds (c|1, 2, 2) [N/m]) -> PlateStrains

in the plate's degrees of freedom (w, bx, by) of corners 1, 2, 3.
"""

from collections.abc import Callable

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .dkmt import dkmt
from .dkt import dkt
from .dst import SHEAR_RATIO_LIMIT, dst
from .mitc3 import mitc3
from .strains import PlateStrains, shear_ratio

Plate = Callable[[Triangles, Array, Array], PlateStrains]

PLATES: dict[str, Plate] = {"dkmt": dkmt, "dst": dst, "dkt": dkt, "mitc3": mitc3}

__all__ = ["PLATES", "SHEAR_RATIO_LIMIT", "Plate", "PlateStrains", "shear_ratio"]
