"""Prismatic joint: motion along the common z axis only; five rows."""

from ...math.arrays import Array
from ...math.compiled import jit
from .rows import fixed_axes, on_z_axis, parallel_z

ROWS = "ddrrr"


@jit
def prismatic(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+4: as cylindrical, and no rotation about z."""
    on_z_axis(rows, k, one, two)
    parallel_z(rows, k + 2, one, two)
    fixed_axes(rows, k + 4, one, two, 0, 1)
