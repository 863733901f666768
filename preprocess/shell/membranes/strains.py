"""Common part of the membranes: the strain of linear displacements."""

from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array
from ..triangles import Triangles


class MembraneStrains(NamedTuple):
    """Strains of c membranes for their degrees of freedom, in E.

    Paper: Eq. (27).

    The stiffness is area mean(strain' A strain) + extra.

    Attributes
    ----------
    strain : (c, q, 3, 9) [1/m] of (exx, eyy, gxy), q = 3 at the three integration points,
        1 where it is constant
    extra : (c, 9, 9) [N/m, N, N m] stiffness of motions not in this strain, or None
    """

    strain: Array
    extra: Array | None

    @property
    def mean_strain(self) -> Array:
        """Mean over the triangle, (c, 3, 9), used by the coupling with bending."""
        one = self.strain.shape[1] == 1
        return self.strain[:, 0] if one else np.asarray(self.strain.mean(axis=1))


def linear_strain(t: Triangles) -> Array:
    """Strain of the displacements sum_i l_i (u_i, v_i), (c, 3, 9) [1/m], independent of tz."""
    Bm = np.zeros((len(t), 3, 9))
    gx, gy = t.grad[..., 0], t.grad[..., 1]
    Bm[:, 0, 0::3] = gx
    Bm[:, 1, 1::3] = gy
    Bm[:, 2, 0::3] = gy
    Bm[:, 2, 1::3] = gx
    return Bm
