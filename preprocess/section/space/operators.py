"""Warping stiffness, stresses and mass of a section for a distribution of material."""

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array
from .space import SectionSpace


def mass_matrix(space: SectionSpace, density: Array) -> Array:
    """Mass per length M (6, 6): kinetic energy v' M v / 2 per metre.

    Parameters
    ----------
    space : the section's integration points
    density : (c, q) at the points [kg/m3]

    Returns
    -------
    (6, 6) for the velocities v = [v1, v2, v3, w1, w2, w3] of the origin of the section axes
    [kg/m, kg, kg m].
    """
    x2, x3 = np.moveaxis(space.points, -1, 0)
    rigid = np.zeros((*x2.shape, 3, 6))  # velocity of a point
    rigid[..., [0, 1, 2], [0, 1, 2]] = 1.0
    rigid[..., 0, 4], rigid[..., 0, 5] = x3, -x2
    rigid[..., 1, 3], rigid[..., 2, 3] = -x3, x2
    columns = rigid.reshape(-1, 6)
    weights = np.repeat((density * space.weights).ravel(), 3)
    M = columns.T @ (weights[:, None] * columns)
    return np.asarray(0.5 * (M + M.T))


def mass_centre(M: Array) -> Array:
    """(x2, x3) of the mass centre, (2,) [m]; the origin if there is no mass."""
    if M[0, 0] == 0.0:
        return np.zeros(2)
    return np.array([-M[0, 5], M[0, 4]]) / M[0, 0]


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
