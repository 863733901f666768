"""Factorised symmetric positive definite matrices."""

from typing import Any

import numpy as np

from .petsc import PETSC_ERRORS, petsc_matrix, reason, sorted_csr
from .stack import HAS_MUMPS, MPI, Array, PETSc


class FactorisationError(Exception):
    """A matrix that should be symmetric positive definite is not."""


class Cholesky:
    """A factorised symmetric positive definite matrix; `update` reuses the symbolic part."""

    def __init__(self, A: Any) -> None:
        self.A = sorted_csr(A)
        self._mat = petsc_matrix(self.A, spd=True)
        self._pc = PETSc.PC().create(comm=MPI.COMM_SELF)
        self._pc.setOperators(self._mat)
        self._pc.setType("cholesky")
        if HAS_MUMPS:
            self._pc.setFactorSolverType("mumps")
        else:
            self._pc.setFactorOrdering(ord_type="nd")
        self._factorise()

    def update(self, A: Any) -> None:
        """Factorise another matrix of exactly the same sparsity pattern."""
        A = sorted_csr(A)
        same = np.array_equal(A.indptr, self.A.indptr) and np.array_equal(A.indices, self.A.indices)
        if not same:
            raise FactorisationError("update() needs a matrix of the same sparsity pattern")
        self.A = A
        index = PETSc.IntType
        self._mat.zeroEntries()
        self._mat.setValuesCSR(A.indptr.astype(index), A.indices.astype(index), A.data)
        self._mat.assemble()
        self._factorise()

    def solve(self, B: Array) -> Array:
        """Solve A X = B for one (n,) or several (n, k) right-hand sides."""
        columns = np.asarray(B, dtype=np.float64).reshape(self.A.shape[0], -1)
        X = self._solve(columns)
        residual = np.abs(self.A @ X - columns).max(axis=0)
        size = self._norm * np.abs(X).max(axis=0) + np.abs(columns).max(axis=0)
        if not np.all(residual <= 1e-10 * size):
            raise FactorisationError(
                f"backward error {np.max(residual / size):.1e} of a Cholesky solve; the matrix is "
                "singular or indefinite: is every rigid motion constrained?"
            )
        return X.reshape(np.shape(B))

    def _factorise(self) -> None:
        try:
            self._pc.setUp()
        except PETSC_ERRORS as error:
            raise FactorisationError(f"the matrix cannot be factorised: {reason(error)}") from error
        self._factor = self._pc.getFactorMatrix()
        if HAS_MUMPS:
            status = self._factor.getMumpsInfog(1)
            negative = self._factor.getMumpsInfog(12)
            if status < 0 or negative > 0:
                raise FactorisationError(
                    f"the matrix is not positive definite (MUMPS: {negative} negative pivots, "
                    f"status {status}): is every rigid motion constrained?"
                )
        self._norm = float(np.abs(self.A).sum(axis=1).max())
        self._check_condition()

    def _check_condition(self) -> None:
        # A singular matrix passes the factorisation with one pivot of round-off size. A random
        # right-hand side finds it; scaling by the diagonal keeps units out of the number.
        scale = np.sqrt(np.abs(self.A.diagonal()))
        z = np.random.default_rng(0).standard_normal(scale.size)
        x = scale * self._solve((scale * z)[:, None])[:, 0]
        growth = np.linalg.norm(x) / np.linalg.norm(z)
        if not growth < 1e13:
            raise FactorisationError(
                f"the matrix is singular (scaled condition above {growth:.0e}): is every rigid "
                "motion constrained and every part connected?"
            )

    def _solve(self, columns: Array) -> Array:
        rhs = PETSc.Mat().createDense(
            columns.shape, array=np.asfortranarray(columns), comm=MPI.COMM_SELF
        )
        rhs.assemble()
        out = PETSc.Mat().createDense(columns.shape, comm=MPI.COMM_SELF)
        out.setUp()
        self._factor.matSolve(rhs, out)
        return np.array(out.getDenseArray())


def cholesky(A: Any) -> Cholesky:
    """Factorise a symmetric positive definite sparse matrix (MUMPS where PETSc has it).

    Raises FactorisationError if the matrix is indefinite or singular.
    """
    return Cholesky(A)
