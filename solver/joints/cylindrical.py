"""Cylindrical joint: a common z axis, along which and about which it moves; four rows."""

from ..bodies.marker import Marker
from ..compiled import jit
from .rows import Rows, on_z_axis, parallel_z

ROWS = "ddrr"


@jit
def cylindrical(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k..k+3: origin of marker two on the z axis of marker one; z axes parallel."""
    on_z_axis(rows, k, one, two)
    parallel_z(rows, k + 2, one, two)
