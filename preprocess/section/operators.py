"""Warping stiffness and stresses of a section for a distribution of material.

With the stiffness C of each point, the paper's matrices are C_hh = E = <G_h, C G_h>,
C_hl = H = <G_h, C G_l> and C_ll = L = <G_l, C G_l>. Only E has to be factorised, so only E is
assembled. H and L are used as loads of stresses: H X = <G_h, C G_l X>. docs/adr/0057 explains why
E is not a compiled form.
"""

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array
from .space import SectionSpace

AT_A_TIME = 64  # cells per block, so that intermediate arrays stay in the cache


class SectionOperators:
    """Computes E on a space for any material; the parts that depend only on the mesh are kept.

    Of several processes, each has the E of its own cells: the sum of all is that of the section.
    """

    def __init__(self, space: SectionSpace) -> None:
        self.space = space
        self._products: sp.csr_matrix | None = None

    def E(self, C: Array) -> sp.csr_matrix:
        """<G_h, C G_h> [Pa] for C (c, 1, 6, 6), constant in each cell, or (c, q, 6, 6) [Pa]."""
        pattern = self.space.pattern
        if C.shape[1] > 1:
            data = pattern.data(self._blocks(C))
        else:  # one stiffness per cell: the part that depends only on the mesh is one sparse matrix
            if self._products is None:
                self._products = pattern.summed(slope_products(self.space))
            by_slopes = self._by_slopes(C[:, 0])
            data = pattern.ordered(self._products @ by_slopes.reshape(-1, 9))
        return pattern.matrix(data)

    def _blocks(self, C: Array) -> Array:
        """Element matrices (c, k^2, 9) with a stiffness at every point, (c, q, 6, 6)."""
        gradients, weighted = self.space.gradients, self.space.weighted_gradients
        c, q, _, k = gradients.shape
        blocks = np.empty((c, k, 9 * k))
        for first in range(0, c, AT_A_TIME):
            some = slice(first, first + AT_A_TIME)
            # stress in direction alpha at a point from the displacement of each node
            stress = np.swapaxes(gradients[some], 2, 3)[:, :, None] @ self._by_slopes(C[some])
            blocks[some] = weighted[some] @ stress.reshape(-1, 2 * q, 9 * k)
        return blocks.reshape(c, k * k, 9)

    def _by_slopes(self, C: Array) -> Array:
        """S' C S: stiffness of a and b for pairs of slopes alpha, beta, (..., 2, 2, 3 a + b)."""
        S = self.space.S_h.reshape(6, 2, 3)
        both = np.einsum("rxa,syb->rsxyab", S, S).reshape(36, 36)
        return np.asarray(C.reshape(*C.shape[:-2], 36) @ both).reshape(*C.shape[:-2], 2, 2, 9)


def slope_products(space: SectionSpace) -> Array:
    """Integrals of d_alpha phi_i d_beta phi_j over each cell, (c, k^2, 4).

    Row k i + j is the pair of nodes, column 2 alpha + beta.
    """
    c, q, _, k = space.gradients.shape
    slopes = space.gradients.reshape(c, q, 2 * k)
    left = space.weighted_gradients.reshape(c, k, q, 2).swapaxes(2, 3)
    products = left.reshape(c, 2 * k, q) @ slopes  # (c, i alpha, beta j)
    return products.reshape(c, k, 2, 2, k).transpose(0, 1, 4, 2, 3).reshape(c, k * k, 4)
