"""Stiffness of a section against warping, and its stresses, for a distribution of material.

With the stiffness C of each point, the paper's matrices are C_hh = E = <G_h, C G_h>,
C_hl = H = <G_h, C G_l> and C_ll = L = <G_l, C G_l>. Only E has to be factorised, so only E is
assembled; H and L are met as loads of stresses: H X = <G_h, C G_l X>. docs/adr/0007 says why no
form compiler is used here.
"""

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp

from ...solver.package.schema import Array
from .. import fenicsx
from .pattern import EVERY
from .space import IN_SECTION, SectionSpace


class SectionOperators:
    """Makes E on a space for any material; what is of the mesh alone is kept.

    The cells are shared out among the processes of a team.
    """

    def __init__(self, space: SectionSpace, team: fenicsx.Team = fenicsx.ALONE) -> None:
        self.space, self.team = space, team
        self._cells = team.share(space.n_cell) if team.size > 1 else EVERY
        self._whole: Array | None = None

    def E(self, C: Array) -> sp.csr_matrix:
        """<G_h, C G_h> [Pa] for C (c, 1, 6, 6), constant in each cell, or (c, q, 6, 6) [Pa]."""
        data: Array | float = 0.0
        for slopes, stiffness in self._groups(C[self._cells]):
            in_plane = stiffness[:, IN_SECTION][:, :, IN_SECTION].reshape(-1, 3, 2, 3, 2)
            columns = in_plane.transpose(0, 2, 4, 1, 3).reshape(-1, 4, 9)
            data = data + self.space.pattern.data(slopes @ columns, self._cells)
        return self.space.pattern.matrix(self.team.total(np.asarray(data)))

    def _groups(self, C: Array) -> Iterator[tuple[Array, Array]]:
        """Points that share a stiffness in every cell: all of them, or one by one."""
        if C.shape[1] == 1:
            if self._whole is None:
                self._whole = slope_products(self.space, self._cells, slice(None))
            yield self._whole, C[:, 0]
        else:
            for q in range(C.shape[1]):
                yield slope_products(self.space, self._cells, slice(q, q + 1)), C[:, q]


def slope_products(space: SectionSpace, cells: slice, points: slice) -> Array:
    """Integrals of d_alpha phi_i d_beta phi_j over each cell, (c, k^2, 4).

    Row k i + j is the pair of nodes, column 2 alpha + beta; for some of the cells, summed over
    some of the points.
    """
    slopes = space.gradients[cells, points]
    c, q, _, k = slopes.shape
    right = slopes.reshape(c, q, 2 * k)
    left = (slopes * space.weights[cells, points, None, None]).reshape(c, q, 2 * k)
    products = np.swapaxes(left, 1, 2) @ right  # (c, alpha i, beta j)
    return products.reshape(c, 2, k, 2, k).transpose(0, 2, 4, 1, 3).reshape(c, k * k, 4)
