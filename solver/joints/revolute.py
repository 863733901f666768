"""Revolute joint: a common point and a common z axis; five rows."""

from ..bodies.marker import Marker
from ..compiled import jit
from .rows import Rows, fixed_axes, same_point

N_ROW = 5


@jit
def revolute(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k..k+4: same origin; z of marker two orthogonal to x and y of marker one."""
    same_point(rows, k, one, two)
    fixed_axes(rows, k + 3, one, two, 0, 2)
    fixed_axes(rows, k + 4, one, two, 1, 2)
