"""Approximate solutions of the equations of a helical beam, as preconditioners.

Both solve for the warping W (n_dof, 6) and the beam strains S_e (6, 6) of given loads and
resultants. They differ in what they take for T, the change of the resultants along the beam.
"""

import numpy as np
import scipy.sparse as sp
from scipy.linalg import null_space

from ...solver.math.arrays import Array
from .. import fenicsx
from .pattern import Restriction
from .twist import TwistedStrains

Residual = tuple[Array, Array]  # loads (n_dof, 6), resultants (6, 6); or warping and beam strains


class AlongAxis:
    """T = 0: one factorisation, good for small |k| h."""

    def __init__(
        self,
        strains: TwistedStrains,
        C: Array,
        kept: Restriction,
        largest_growth: float,
    ) -> None:
        E = strains.E(C)
        self._factor = fenicsx.cholesky(kept.matrix(E.data), largest_growth=largest_growth)
        self.free, self.n = kept.free, strains.space.n_dof
        stress = C @ strains.strain_along_beam(strains.Z)
        self.HZ, self.LZ = strains.load_in_section(stress), strains.load_along_beam(stress)
        self.ZLZ = strains.Z.T @ self.LZ
        self._V = np.zeros((self.n, 6))
        self._V[self.free] = self._factor.solve(self.HZ[self.free])
        schur = self.ZLZ - self.HZ.T @ self._V
        self._schur = 0.5 * (schur + schur.T)
        # energies of warping and beam strains in the same units
        self._root = np.sqrt(np.abs(E.diagonal()[self.free]))[:, None]
        self._unit = np.sqrt(np.abs(np.diag(self.ZLZ)))[:, None]

    @property
    def growth(self) -> float:
        """Growth of a random load by the solution."""
        return self._factor.growth

    def solve(self, load: Array, resultants: Array) -> Residual:
        """Warping and beam strains, with any number of columns."""
        W = np.zeros_like(load)
        W[self.free] = self._factor.solve(load[self.free])
        S_e: Array = np.array(
            np.linalg.solve(self._schur, resultants - self.HZ.T @ W), dtype=np.float64
        )
        return W - self._V @ S_e, S_e

    def packed(self, W: Array, S_e: Array) -> Array:
        """Both unknowns as one vector."""
        parts = (W[self.free] * self._root).ravel(), (S_e * self._unit).ravel()
        return np.concatenate(parts)

    def unpacked(self, z: Array) -> Residual:
        """The unknowns of a vector."""
        W = np.zeros((self.n, 6))
        W[self.free] = z[:-36].reshape(-1, 6) / self._root
        return W, z[-36:].reshape(6, 6) / self._unit


class Waves:
    """T without its nilpotent part, whose eigenvalues are 0 and +-i |k|: two factorisations.

    Along the eigenvectors of i |k| the equations are complex and Hermitian; they are solved as real
    ones of twice the size. The nilpotent part is found in a few iterations.
    """

    def __init__(
        self,
        strains: TwistedStrains,
        C: Array,
        kept: Restriction,
        T: Array,
        simple: AlongAxis,
    ) -> None:
        self._simple = simple
        kappa = float(np.linalg.norm(strains.k))
        self._basis, self._inverse = _eigenvectors(T, kappa)
        real, imaginary = (kept.matrix(part.data) for part in strains.wave(C, kappa))
        doubled = sp.bmat([[real, -imaginary], [imaginary, real]], format="csr")
        doubled.sort_indices()
        self._factor = fenicsx.cholesky(doubled, largest_growth=np.inf)
        self._B = simple.HZ - 1j * kappa * simple.LZ  # (n, 6)
        self._V = self._back(self._B)
        self._schur = simple.ZLZ - self._B.conj().T @ self._V

    def _back(self, load: Array) -> Array:
        """Complex solution (n_dof, m) of complex loads."""
        free = self._simple.free
        both = self._factor.solve(np.concatenate([load[free].real, load[free].imag]))
        half = len(both) // 2
        out = np.zeros(load.shape, dtype=complex)
        out[free] = both[:half] + 1j * both[half:]
        return out

    def solve(self, load: Array, resultants: Array) -> Residual:
        """Warping (n_dof, 6) and beam strains (6, 6)."""
        loads, forces = load @ self._basis, resultants @ self._basis
        W_0, S_0 = self._simple.solve(loads[:, :2].real, forces[:, :2].real)
        W_1 = self._back(loads[:, 2:4])
        S_1 = np.linalg.solve(self._schur, forces[:, 2:4] - self._B.conj().T @ W_1)
        W_1 = W_1 - self._V @ S_1
        W = np.concatenate([W_0, W_1, W_1.conj()], axis=1) @ self._inverse
        S_e = np.concatenate([S_0, S_1, S_1.conj()], axis=1) @ self._inverse
        return W.real, S_e.real


def _eigenvectors(T: Array, kappa: float) -> tuple[Array, Array]:
    """Vectors of the eigenvalues 0, i kappa and -i kappa of the semisimple part of T, two each.

    (6, 6) as columns, and their inverse. T is scaled, because its rows have different units.
    """
    unit = np.array([1.0] * 3 + [1.0 / kappa] * 3)
    scaled = T * unit[None, :] / unit[:, None] / kappa  # eigenvalues 0, i, -i
    square = scaled @ scaled + np.eye(6)
    at_zero, others = (
        null_space(scaled @ scaled, rcond=1e-9),
        null_space(square @ square, rcond=1e-9),
    )
    part = np.linalg.lstsq(others, scaled @ others, rcond=None)[0]
    semisimple = part @ (3.0 * np.eye(4) + part @ part) / 2.0
    values, vectors = np.linalg.eig(semisimple)
    waves = others @ vectors[:, values.imag > 0.0]
    basis = unit[:, None] * np.concatenate([at_zero, waves, waves.conj()], axis=1)
    return basis, np.linalg.inv(basis)
