"""Universal joint: a common point and two crossing axes at right angles; four rows."""

from ...math.arrays import Array
from ...math.compiled import jit
from .rows import fixed_axes, same_point

ROWS = "dddr"


@jit
def universal(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+3: same origin; z of marker one orthogonal to x of marker two.

    Marker one turns about its z, marker two about its x: the arms of the cross.
    """
    same_point(rows, k, one, two)
    fixed_axes(rows, k + 3, one, two, 2, 0)
