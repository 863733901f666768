"""Conjugate gradients with two grids: the unknowns, and a few of them that a factorisation solves.

The memory is that of the matrix, and the time grows with the number of unknowns, where factors of a
solid grow with its power 4/3.
"""

import warnings
from typing import Any

import numpy as np
import scipy.sparse.linalg as spla

from ...solver.math.arrays import Array
from ..parts import own
from .eigen import checked, eigenpairs
from .factorisation import PETSC_ERRORS, destroy, reason, sorted_csr, use_mumps
from .libraries import EigenError, FactorisationError, PETSc
from .team import ALONE, Distribution, Team

RTOL = 1e-10  # of the residual relative to the load
MOST = 100  # iterations; 10 to 20 are usual
SWEEPS = 2  # Chebyshev steps with symmetric Gauss-Seidel before and after the coarse solution
BACKWARD = 1e-10  # error that a solution may have, as that by factors
GUARD = 4  # vectors that converge beside those asked for
EIGEN_RTOL = 1e-7  # of the residual of an eigenvector; its value has the square as error
EIGEN_MOST = 80


class TwoGrids:
    """A symmetric positive definite matrix A (n, n) and its coarse unknowns.

    Parameters
    ----------
    P : (n, k) values of all unknowns from k coarse ones
    team : processes that have parts of A
    """

    def __init__(self, A: Any, P: Any, team: Team = ALONE) -> None:
        self.A, self.P, self._team = A, sorted_csr(P), team
        parts = [sorted_csr(own(B)) for B in (A, self.P.T @ A @ self.P)]
        self._rows, few = (Distribution(team, B) for B in parts)
        fine, small = self._rows.matrix(parts[0], spd=True), few.matrix(parts[1], spd=True)
        here = self.P[self._rows.rows]
        csr = (here.indptr.astype(few.number.dtype), few.number[here.indices], here.data)
        size = (self._rows.n_own, self._rows.n), (few.n_own, few.n)
        interpolation = PETSc.Mat().createAIJ(size, csr=csr, comm=team.comm)
        ksp = PETSc.KSP().create(comm=team.comm)
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
        use_mumps(bottom.getPC(), few.n, solid=True)
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
        parts = own(K_coarse), own(M_coarse)
        values, X = eigenpairs(*parts, wide, team=self._team, solid=True)
        X = self.P @ X
        # of inertia: the stress of coarse functions jumps between cells, so that A X is far larger
        force = values * np.linalg.norm(M @ X, axis=0)
        near = spla.LinearOperator(
            self.A.shape,
            matvec=lambda x: self._columns(self._pc.apply, x.ravel()),
            matmat=lambda B: self._columns(self._pc.apply, B),
            dtype=np.float64,
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # SciPy warns where guards have not converged
            _, X = spla.lobpcg(
                self.A.__matmul__,
                X,
                M.__matmul__,
                near,
                tol=EIGEN_RTOL * force.min(),
                maxiter=EIGEN_MOST,
                largest=False,
            )
        if not np.isfinite(X).all():
            raise EigenError(f"{count} modes: the iteration failed; expected fewer unknowns")
        return checked(own(self.A), own(M), X[:, :count], self._team)

    def _columns(self, solve: Any, B: Array) -> Array:
        out = np.empty_like(B, dtype=np.float64)
        table, columns = out.reshape(len(B), -1), np.reshape(B, (len(B), -1))
        load, solution = (self._held[1].createVecRight() for _ in range(2))
        for k in range(columns.shape[1]):
            load.setArray(columns[self._rows.rows, k])
            solve(load, solution)
            table[:, k] = self._rows.gathered(solution.getArray())
        destroy(load, solution)
        return out
