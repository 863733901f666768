"""Spherical joint: a common point; three rows."""

from ..bodies.marker import Marker
from ..compiled import jit
from .rows import Rows, same_point

ROWS = "ddd"


@jit
def spherical(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k..k+2: same origin."""
    same_point(rows, k, one, two)
