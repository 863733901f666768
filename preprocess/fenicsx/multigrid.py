"""Conjugate gradients with two grids: the unknowns, and a few of them that a factorisation solves.

The memory is that of the matrix, and the time grows with the number of unknowns, where factors of a
solid grow with its power 4/3.
"""

import warnings
from typing import Any

import numpy as np
import scipy.sparse.linalg as spla

from ...solver.math.arrays import Array
from .eigen import checked, eigenpairs
from .factorisation import PETSC_ERRORS, destroy, reason, sorted_csr, use_mumps
from .stack import EigenError, FactorisationError, PETSc
from .team import ALONE, Distribution

RTOL = 1e-10  # of the residual relative to the load
MOST = 100  # iterations; 10 to 20 are usual
SWEEPS = 2  # Chebyshev steps with symmetric Gauss-Seidel before and after the coarse solution
BACKWARD = 1e-10  # error that a solution may have, as that by factors
GUARD = 4  # vectors that converge beside those asked for
EIGEN_RTOL = 1e-8  # of the residual of an eigenvector; its value has the square as error
EIGEN_MOST = 80


class TwoGrids:
    """A symmetric positive definite matrix A (n, n) and its coarse unknowns.

    Parameters
    ----------
    P : (n, k) values of all unknowns from k coarse ones
    """

    def __init__(self, A: Any, P: Any) -> None:
        self.A, self.P = sorted_csr(A), sorted_csr(P)
        coarse = sorted_csr(self.P.T @ self.A @ self.P)
        index = PETSc.IntType
        csr = (self.P.indptr.astype(index), self.P.indices.astype(index), self.P.data)
        interpolation = PETSc.Mat().createAIJ(self.P.shape, csr=csr, comm=ALONE.comm)
        fine, small = (Distribution(ALONE, B).matrix(B, spd=True) for B in (self.A, coarse))
        ksp = PETSc.KSP().create(comm=ALONE.comm)
        ksp.setType("cg")
        ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        ksp.setTolerances(rtol=RTOL, atol=0.0, max_it=MOST)
        ksp.setOperators(fine)
        pc = ksp.getPC()
        pc.setType("mg")
        pc.setMGLevels(2)
        pc.setMGInterpolation(1, interpolation)
        smoother, bottom = pc.getMGSmoother(1), pc.getMGCoarseSolve()
        smoother.setOperators(fine)
        smoother.setType("chebyshev")
        smoother.setTolerances(max_it=SWEEPS)
        smoother.getPC().setType("sor")
        bottom.setOperators(small)
        bottom.setType("preonly")
        bottom.getPC().setType("cholesky")
        use_mumps(bottom.getPC(), coarse.shape[0], solid=True)
        self._ksp, self._pc = ksp, pc
        self._held = [interpolation, fine, small]
        try:
            ksp.setUp()
        except PETSC_ERRORS as error:
            raise FactorisationError(f"the matrix cannot be factorised: {reason(error)}") from error

    def solve(self, B: Array) -> Array:
        """Solve A X = B for (n,) or (n, k). Raises FactorisationError if that fails."""
        X = self._columns(self._ksp.solve, B)
        residual = np.abs(self.A @ X - B).max()
        size = np.abs(self.A.diagonal()).max() * np.abs(X).max() + np.abs(B).max()
        if not residual <= BACKWARD * size:
            raise FactorisationError(
                f"backward error {residual / size:.1e} of conjugate gradients after at most {MOST} "
                "steps: is every rigid motion constrained, and no cell nearly flat?"
            )
        return X

    def close(self) -> None:
        """Free the memory."""
        destroy(self._ksp, *self._held)

    def eigenpairs(self, M: Any, count: int) -> tuple[Array, Array]:
        """Lowest values and vectors of A x = value M x, by LOBPCG from the coarse ones.

        Raises EigenError if they do not converge.
        """
        wide = count + GUARD
        K_coarse, M_coarse = (self.P.T @ B @ self.P for B in (self.A, M))
        X = self.P @ eigenpairs(K_coarse, M_coarse, wide, solid=True)[1]
        force = np.linalg.norm(self.A @ X, axis=0) / np.sqrt(np.einsum("ni,ni->i", X, M @ X))
        near = spla.LinearOperator(
            self.A.shape,
            matvec=lambda x: self._columns(self._pc.apply, x.ravel()),
            matmat=lambda B: self._columns(self._pc.apply, B),
            dtype=np.float64,
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # SciPy warns where guards have not converged
            _, X = spla.lobpcg(
                self.A, X, M, near, tol=EIGEN_RTOL * force.min(), maxiter=EIGEN_MOST, largest=False
            )
        if not np.isfinite(X).all():
            raise EigenError(f"{count} modes: the iteration failed; expected fewer unknowns")
        return checked(self.A, sorted_csr(M), X[:, :count], ALONE)

    def _columns(self, solve: Any, B: Array) -> Array:
        out = np.empty_like(B, dtype=np.float64)
        table, columns = out.reshape(len(B), -1), np.reshape(B, (len(B), -1))
        load, solution = (self._held[1].createVecRight() for _ in range(2))
        for k in range(columns.shape[1]):
            load.setArray(columns[:, k])
            solve(load, solution)
            table[:, k] = solution.getArray()
        destroy(load, solution)
        return out
