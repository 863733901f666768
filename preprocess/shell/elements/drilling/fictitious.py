"""A fictitious stiffness between the drilling rotations of a triangle."""

from typing import Any

from ufl import as_matrix, as_vector

from ..cell import Cell
from .contract import Drilling

DIFFERENCES = ((1.0, -0.5, -0.5), (-0.5, 1.0, -0.5), (-0.5, -0.5, 1.0))


def fictitious(t: Cell) -> list[tuple[Any, Any]]:
    """Stiffness factor A66 area [1 -1/2 -1/2; -1/2 1 -1/2; -1/2 -1/2 1] of (tz1, tz2, tz3).

    It removes the singularity of nodes with all triangles in one plane. Three equal tz have no
    energy for any motion of the triangle. A flat shell therefore keeps one zero-frequency mode, and
    the rotation of the triangle about its normal is not coupled with tz. No factor is suitable for
    warped shells.
    """
    tz = as_vector([corner.tz for corner in t.corners])
    return [(t.drilling_factor * t.A[2, 2] * t.area * as_matrix(DIFFERENCES) * tz, tz)]


DRILLING = Drilling("fictitious", fictitious, free_rotation=True)
