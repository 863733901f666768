"""Cylindrical joint: a common z axis, along which and about which it moves; four rows."""

from ...math.arrays import Array
from ...math.compiled import jit
from .rows import on_z_axis, parallel_z

ROWS = "ddrr"


@jit
def cylindrical(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+3: origin of marker two on the z axis of marker one; z axes parallel."""
    on_z_axis(rows, k, one, two)
    parallel_z(rows, k + 2, one, two)
