"""Point on a line: the origin of marker two moves along the z axis of marker one; two rows."""

from ..bodies.marker import Marker
from ..compiled import jit
from .rows import Rows, on_z_axis

ROWS = "dd"


@jit
def point_on_line(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k, k+1: origin of marker two on the z axis of marker one."""
    on_z_axis(rows, k, one, two)
