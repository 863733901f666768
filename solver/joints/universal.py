"""Universal joint: a common point and two crossing axes at right angles; four rows."""

from ..bodies.marker import Marker
from ..compiled import jit
from .rows import Rows, fixed_axes, same_point

ROWS = "dddr"


@jit
def universal(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k..k+3: same origin; z of marker one orthogonal to x of marker two.

    Marker one turns about its z, marker two about its x: the arms of the cross.
    """
    same_point(rows, k, one, two)
    fixed_axes(rows, k + 3, one, two, 2, 0)
