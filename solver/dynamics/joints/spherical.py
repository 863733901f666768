"""Spherical joint: a common point; three rows."""

from ...math.arrays import Array
from ...math.compiled import jit
from .rows import same_point

ROWS = "ddd"


@jit
def spherical(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+2: same origin."""
    same_point(rows, k, one, two)
