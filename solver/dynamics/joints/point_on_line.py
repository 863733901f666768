"""Point on a line: the origin of marker two moves along the z axis of marker one; two rows."""

from ...math.arrays import Array
from ...math.compiled import jit
from .rows import on_z_axis

ROWS = "dd"


@jit
def point_on_line(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k, k+1: origin of marker two on the z axis of marker one."""
    on_z_axis(rows, k, one, two)
