"""Contract of the plate of a quadrilateral: what its file supplies.

It is one file of this folder with an object of class `QuadPlate`, and a line in `QUADS` of
solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
The membrane (hybrid.py) is the same for all of them.

    strains(q, D, Ds) -> QuadStrains

    q    c quadrilaterals in their own axes E (quadrilaterals.py)
    D    (c|1, 3, 3) bending stiffness in E, of (kxx, kyy, kxy) [N m]
    Ds   (c|1, 2, 2) transverse shear stiffness, corrected, of (gxz, gyz) [N/m]

gives curvature and shear strain at the 2 x 2 points `GAUSS` per unit of the twelve degrees of
freedom (w, bx, by) of corners 1 to 4 [m, rad], with the signs of plates/contract.py. A rigid
motion has no strain. strains.py has the common parts.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ....solver.math.arrays import Array
from ..quadrilaterals import Quadrilaterals
from .strains import QuadStrains


@dataclass(frozen=True)
class QuadPlate:
    """Bending and transverse shear of a quadrilateral.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    strains : see above
    internal : whether cells have rotations of their own (internal.py)
    """

    name: str
    strains: Callable[[Quadrilaterals, Array, Array], QuadStrains]
    internal: bool = False
