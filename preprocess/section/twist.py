"""Strains of a section of an initially twisted and curved beam, exact in twist and curvature.

The reference line has the constant twist k1 and curvatures k2, k3: b_i' = k x b_i for the section's
axes b_i. With g = 1 - x2 k3 + x3 k2 the strain of a displacement w of the section and of a beam
strain e is G_k w + G_l (w' + Z e) / g, where

    G_k w = G_h w + G_l (k x w + k1 (x3 w,2 - x2 w,3)) / g,

the columns of Z are the rigid motions of the section, and the volume is g dA dx1.
"""

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array
from ...solver.math.rotations import skew
from .errors import SectionError
from .operators import AT_A_TIME
from .space import ALONG_BEAM, BY_SLOPE, SectionSpace
from .warping import motions_of_beam


class TwistedStrains:
    """Strain operators of a space for initial twist and curvature k (3,) [rad/m]."""

    def __init__(self, space: SectionSpace, k: Array) -> None:
        self.space, self.k = space, np.asarray(k, dtype=float)
        x2, x3 = np.moveaxis(space.points, -1, 0)
        self.g = 1.0 - x2 * self.k[2] + x3 * self.k[1]  # (c, q)
        self.least_g = float(self.g[space.weights > 0.0].min())
        if not self.least_g > 0.0:
            far = int(np.argmin(np.where(space.weights > 0.0, self.g, np.inf)))
            place = space.points.reshape(-1, 2)[far]
            raise SectionError(
                f"initial_curvature: the point ({place[0]:.4g}, {place[1]:.4g}) lies beyond the "
                f"centre of curvature: 1 - x2 k3 + x3 k2 = {self.least_g:.3g}, expected above 0"
            )

    @cached_property
    def Z(self) -> Array:
        """Rigid motions (n_dof, 6) whose change along the beam is a unit beam strain."""
        return motions_of_beam(self.space)

    def strain_in_section(self, W: Array) -> Array:
        """G_k W at the points, (c, q, 6, m), for displacement columns W (n_dof, m)."""
        strain = self.space.strain_in_section(W)
        strain[:, :, ALONG_BEAM] += self._turning(W) / self.g[..., None, None]
        return strain

    def strain_along_beam(self, W: Array) -> Array:
        """G_l W / g at the points, (c, q, 6, m): the strain of a change W per x1."""
        return self.space.strain_along_beam(W) / self.g[..., None, None]

    def load_in_section(self, stress: Array) -> Array:
        """Integral of (G_k w)' stress g for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        space = self.space
        traction = np.take(stress, ALONG_BEAM, axis=2)
        lever = np.einsum("ab,cqbm->cqam", skew(self.k).T, traction)  # of k x w
        c, q, _, m = stress.shape
        partner = np.take(stress * self.g[..., None, None], BY_SLOPE, axis=2)
        slopes = partner.reshape(c, q, 2, 3, m)
        x2, x3 = np.moveaxis(space.points, -1, 0)
        slopes[:, :, 0] += (self.k[0] * x3)[..., None, None] * traction
        slopes[:, :, 1] -= (self.k[0] * x2)[..., None, None] * traction
        return space.load_of_slopes(slopes) + space.load(lever)

    def load_along_beam(self, stress: Array) -> Array:
        """Integral of (G_l w)' stress for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        return self.space.load_along_beam(stress)

    def work(self, stress: Array, strain: Array) -> Array:
        """Integral of stress' strain g over the section, (m, n)."""
        return self.space.work(self.g[..., None, None] * stress, strain)

    def _turning(self, W: Array) -> Array:
        """K x w + k1 (x3 w,2 - x2 w,3) at the points, (c, q, 3, m)."""
        space = self.space
        slope = space.slopes(W)  # (c, q, 2, 3, m)
        x2, x3 = np.moveaxis(space.points, -1, 0)
        turning = np.einsum("ab,cqbm->cqam", skew(self.k), space.at_points(W))
        turning += (self.k[0] * x3)[..., None, None] * slope[:, :, 0]
        turning -= (self.k[0] * x2)[..., None, None] * slope[:, :, 1]
        return turning

    def E(self, C: Array) -> sp.csr_matrix:
        """Integral of G_k' C G_k g [Pa], for C (c, 1 or q, 6, 6) [Pa]."""
        return self._assembled(C, 0.0)[0]

    def wave(self, C: Array, kappa: float) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Real (symmetric) and imaginary (skew) part of the integral of S' C S g.

        S = G_k + i kappa G_l / g is the strain of a warping that varies as exp(i kappa x1).
        """
        return self._assembled(C, kappa)

    def _assembled(self, C: Array, kappa: float) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        space = self.space
        c, _, _, k = space.gradients.shape
        real, imaginary = np.empty((2, c, k, k, 9))
        for first in range(0, c, AT_A_TIME):
            some = slice(first, first + AT_A_TIME)
            within, along = self._strains_of_unknowns(some)  # (s, q, 6, 3 k) each
            weight = (space.weights[some] * self.g[some])[..., None, None]
            stress = weight * (C[some] @ within)
            real[some] = _by_nodes(within, stress)
            if kappa:
                change = weight * (C[some] @ along)
                real[some] += kappa**2 * _by_nodes(along, change)
                mixed = _by_nodes(within, change) - _by_nodes(along, stress)
                imaginary[some] = kappa * mixed
        shape = (c, k * k, 9)
        pattern = space.pattern
        parts = [real, imaginary] if kappa else [real]
        matrices = [pattern.matrix(pattern.data(part.reshape(shape))) for part in parts]
        return matrices[0], matrices[-1]

    def _strains_of_unknowns(self, some: slice) -> tuple[Array, Array]:
        """G_k and G_l / g of the unknowns of some cells, (s, q, 6, 3 k) each."""
        space = self.space
        gradients = space.gradients[some]
        s, q, _, k = gradients.shape
        values = space.values[some] if space.values.ndim == 3 else space.values[None]
        over = 1.0 / self.g[some][..., None]
        values = np.broadcast_to(values, (s, q, k)) * over
        within, along = np.zeros((2, s, q, 6, k, 3))
        for alpha in range(2):
            for a in range(3):
                within[:, :, BY_SLOPE[3 * alpha + a], :, a] += gradients[:, :, alpha]
        x2, x3 = np.moveaxis(space.points[some], -1, 0)
        turn = x3[..., None] * gradients[:, :, 0] - x2[..., None] * gradients[:, :, 1]
        cross = skew(self.k)
        for a, row in enumerate(ALONG_BEAM):
            within[:, :, row, :, a] += self.k[0] * turn * over
            along[:, :, row, :, a] = values
            for b in range(3):
                within[:, :, row, :, b] += cross[a, b] * values
        shape = (s, q, 6, 3 * k)
        return within.reshape(shape), along.reshape(shape)


def _by_nodes(strain: Array, stress: Array) -> Array:
    """Work of stresses (s, q, 6, 3 k) on strains of the unknowns, (s, k, k, 9)."""
    s, q, _, columns = strain.shape
    k = columns // 3
    whole = strain.reshape(s, 6 * q, -1).swapaxes(1, 2) @ stress.reshape(s, 6 * q, -1)
    return whole.reshape(s, k, 3, k, 3).transpose(0, 1, 3, 2, 4).reshape(s, k, k, 9)
