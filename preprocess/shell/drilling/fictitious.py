"""A fictitious stiffness between the drilling rotations of a triangle."""

import numpy as np

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .contract import Drilling

DIFFERENCES = 1.5 * np.eye(3) - 0.5  # [1 -1/2 -1/2; ..]


def fictitious(t: Triangles, A: Array, factor: float) -> Array:
    """Stiffness factor A66 area [1 -1/2 -1/2; -1/2 1 -1/2; -1/2 -1/2 1] of (tz1, tz2, tz3).

    It removes the singularity of nodes with all triangles in one plane. Three equal tz have no
    energy for any motion of the triangle. A flat shell therefore keeps one zero-frequency mode, and
    the rotation of the triangle about its normal is not coupled with tz. No factor is suitable for
    warped shells.

    Returns
    -------
    (c, 9, 9)
    """
    K = np.zeros((len(t), 9, 9))
    K[:, 2::3, 2::3] = (factor * A[..., 2, 2] * t.area)[:, None, None] * DIFFERENCES
    return K


DRILLING = Drilling("fictitious", fictitious, free_rotation=True)
