"""Revolute joint: a common point and a common z axis; five rows."""

from ...math.arrays import Array
from ...math.compiled import jit
from .rows import parallel_z, same_point

ROWS = "dddrr"


@jit
def revolute(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+4: same origin; z of marker two orthogonal to x and y of marker one."""
    same_point(rows, k, one, two)
    parallel_z(rows, k + 3, one, two)
