"""Planar joint: motion in the plane normal to z, and rotation about z; three rows."""

from ...math.arrays import Array
from ...math.compiled import jit
from .rows import along_axis, parallel_z

ROWS = "drr"


@jit
def planar(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+2: origin of marker two in the x-y plane of marker one; z axes parallel."""
    along_axis(rows, k, one, two, 2, 0.0, 0.0, 0.0)
    parallel_z(rows, k + 1, one, two)
