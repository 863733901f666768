"""Strains of a section of an initially twisted and curved beam, exact in twist and curvature.

Of a displacement w of the section and a beam strain e they are G_k w + G_l (w' + Z e) / g; see
strains.py. DOLFINx evaluates G_k at the points, as the 6x9 matrix S of (w, w,2, w,3).
"""

from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from ufl import SpatialCoordinate

from ....solver.math.arrays import Array
from ..errors import SectionError
from ..space.operators import AT_A_TIME
from ..space.space import SectionSpace
from ..space.strains import coefficients, twisted_strain_in_section, volume
from .warping import motions_of_beam


class TwistedStrains:
    """Strain operators of a space for initial twist and curvature k (3,) [rad/m]."""

    def __init__(self, space: SectionSpace, k: Array) -> None:
        self.space, self.k = space, np.asarray(k, dtype=float)
        self.g: Array = volume(self.k, np.moveaxis(space.points, -1, 0))  # (c, q)
        self.least_g = float(self.g[space.weights > 0.0].min())
        if not self.least_g > 0.0:
            far = int(np.argmin(np.where(space.weights > 0.0, self.g, np.inf)))
            place = space.points.reshape(-1, 2)[far]
            raise SectionError(
                f"initial_curvature: the point ({place[0]:.4g}, {place[1]:.4g}) lies beyond the "
                f"centre of curvature: 1 - x2 k3 + x3 k2 = {self.least_g:.3g}, expected above 0"
            )

    @cached_property
    def S(self) -> Array:
        """G_k w from the values and slopes of w at the points, (c, q, 6, 9)."""
        out = np.zeros((*self.g.shape, 6, 9))
        for part, (reference, _) in self.space.rules:
            out[part.rows, : len(reference)] = part.evaluated(_rows, reference, k=self.k)
        return out

    @cached_property
    def Z(self) -> Array:
        """Rigid motions (n_dof, 6) whose change along the beam is a unit beam strain."""
        return motions_of_beam(self.space)

    def strain_in_section(self, W: Array) -> Array:
        """G_k W at the points, (c, q, 6, m), for displacement columns W (n_dof, m)."""
        values, slopes = self.space.at_points(W), self.space.slopes(W)
        return np.asarray(self.S @ np.concatenate([values, slopes], axis=2))

    def strain_along_beam(self, W: Array) -> Array:
        """G_l W / g at the points, (c, q, 6, m): the strain of a change W per x1."""
        return self.space.strain_along_beam(W) / self.g[..., None, None]

    def load_in_section(self, stress: Array) -> Array:
        """Integral of (G_k w)' stress g for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        partner = np.swapaxes(self.S, 2, 3) @ (stress * self.g[..., None, None])
        return self.space.load(partner[:, :, :3]) + self.space.load_of_slopes(partner[:, :, 3:])

    def load_along_beam(self, stress: Array) -> Array:
        """Integral of (G_l w)' stress for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        return self.space.load_along_beam(stress)

    def work(self, stress: Array, strain: Array) -> Array:
        """Integral of stress' strain g over the section, (m, n)."""
        return self.space.work(self.g[..., None, None] * stress, strain)

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
        """G_k and G_l / g of the unknowns of some cells, (s, q, 6, 3 k) each, columns (a, k)."""
        space = self.space
        gradients = space.gradients[some]
        s, q, _, k = gradients.shape
        values = space.values[some] if space.values.ndim == 3 else space.values[None]
        values = np.broadcast_to(values, (s, q, k))
        fields = np.concatenate([values[:, :, None], gradients], axis=2)  # (s, q, 3, k)
        S = self.S[some].reshape(s, q, 6, 3, 3).swapaxes(3, 4)  # [..., row, a, field]
        within = S.reshape(s, q, 18, 3) @ fields
        along = np.einsum("ra,sqk->sqrak", space.S_l, values / self.g[some][..., None])
        return within.reshape(s, q, 6, 3 * k), along.reshape(s, q, 6, 3 * k)


def _rows(domain: Any, _u: Any, k: Any) -> Any:
    """S (6, 9) of G_k w = S (w, w,2, w,3)."""
    return coefficients(partial(twisted_strain_in_section, k=k, x=SpatialCoordinate(domain)))


def _by_nodes(strain: Array, stress: Array) -> Array:
    """Work of stresses (s, q, 6, 3 k) on strains of the unknowns, (s, k, k, 9)."""
    s, q, _, columns = strain.shape
    k = columns // 3
    whole = strain.reshape(s, 6 * q, -1).swapaxes(1, 2) @ stress.reshape(s, 6 * q, -1)
    return whole.reshape(s, 3, k, 3, k).transpose(0, 2, 4, 1, 3).reshape(s, k, k, 9)
