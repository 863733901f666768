"""Eigenpairs of large sparse matrices by SLEPc."""

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from .petsc import PETSC_ERRORS, petsc_matrix, reason, sorted_csr
from .stack import HAS_MUMPS, MPI, Array, PETSc, SLEPc


class EigenError(Exception):
    """Fewer eigenpairs than asked for, or eigenpairs that do not satisfy their equation."""


def eigenpairs(
    K: Any, M: Any, n_mode: int, *, target: float = 0.0, tolerance: float = 1e-12
) -> tuple[Array, Array]:
    """Eigenpairs of K x = lambda M x nearest to `target`, ascending and M-orthonormal.

    Parameters
    ----------
    K : (n, n) symmetric sparse; K - target M must be regular. Positive definite at target 0;
        a structure free to move needs a negative target.
    M : (n, n) symmetric positive semi-definite sparse (lumped masses without rotary inertia are
        allowed: massless directions have no eigenpair and are not returned).
    n_mode : number of pairs, up to the number of finite eigenvalues
    target : shift of the shift-and-invert transformation, in the unit of lambda
    tolerance : relative tolerance of the Krylov-Schur iteration

    Returns
    -------
    (n_mode,) eigenvalues and (n, n_mode) vectors with X' M X = I. Signs are SLEPc's.

    Raises
    ------
    EigenError : more pairs asked for than exist, too few converged, or a residual too large.
    """
    K, M = sorted_csr(K), sorted_csr(M)
    n_dof = K.shape[0]
    # rows of M without an entry are massless: each takes one eigenvalue to infinity
    n_finite = int(np.count_nonzero(np.abs(M).sum(axis=1)))
    if not 1 <= n_mode <= n_finite:
        raise EigenError(
            f"{n_mode} modes asked for: the problem of {n_dof} unknowns has {n_finite} of finite "
            "frequency"
        )
    n_krylov = max(2 * n_mode + 10, n_mode + 20)
    if n_krylov < n_finite:
        X = _krylov_schur(K, M, n_mode, n_krylov, target, tolerance)
    else:  # the Krylov space would be the whole space
        X = _dense(K, M, n_mode, target)
    return _checked(K, M, X)


def _krylov_schur(
    K: sp.csr_matrix, M: sp.csr_matrix, n_mode: int, n_krylov: int, target: float, tolerance: float
) -> Array:
    eps = SLEPc.EPS().create(comm=MPI.COMM_SELF)
    eps.setOperators(petsc_matrix(K, spd=target == 0.0), petsc_matrix(M, spd=False))
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(target)
    eps.setDimensions(nev=n_mode, ncv=n_krylov)
    eps.setTolerances(tol=tolerance, max_it=500)
    transformation = eps.getST()
    transformation.setType(SLEPc.ST.Type.SINVERT)
    transformation.setShift(target)
    ksp = transformation.getKSP()
    ksp.setType("preonly")
    pc = ksp.getPC()
    # PETSc's own Cholesky does not pivot: an indefinite matrix gets an LU there
    pc.setType("cholesky" if HAS_MUMPS or target <= 0.0 else "lu")
    if HAS_MUMPS:
        pc.setFactorSolverType("mumps")
    start = PETSc.Vec().createSeq(K.shape[0], comm=MPI.COMM_SELF)
    start.setArray(np.random.default_rng(0).standard_normal(K.shape[0]))  # runs must reproduce
    eps.setInitialSpace([start])
    try:
        eps.solve()
    except PETSC_ERRORS as error:
        raise EigenError(
            f"K - {target:g} M cannot be factorised ({reason(error)}): is the body free to move? "
            "A negative target is needed then"
        ) from error
    n_converged = eps.getConverged()
    if n_converged < n_mode:
        raise EigenError(
            f"{n_converged} of {n_mode} modes converged in {eps.getIterationNumber()} iterations "
            f"(tolerance {tolerance:g})"
        )
    vector = start.duplicate()
    X = np.empty((K.shape[0], n_mode))
    for i in range(n_mode):
        eps.getEigenvector(i, vector)
        X[:, i] = vector.getArray()
    return X


def _dense(K: sp.csr_matrix, M: sp.csr_matrix, n_mode: int, target: float) -> Array:
    # M may be singular and K - shift M is not: its pencil is the inverse one. Beyond the lowest
    # eigenvalue the shifted matrix is indefinite, so a positive target shifts nothing here.
    shift = min(target, 0.0)
    shifted = (K - shift * M).toarray()
    try:
        inverse, X = scipy.linalg.eigh(M.toarray(), shifted)
    except scipy.linalg.LinAlgError as error:
        raise EigenError(
            "K is not positive definite: is the body free to move? A negative target is needed then"
        ) from error
    finite = inverse > 1e-15 * inverse[-1]
    values = np.full_like(inverse, np.inf)
    values[finite] = shift + 1.0 / inverse[finite]
    order = np.argsort(np.abs(values - target), kind="stable")[:n_mode]
    if not np.all(np.isfinite(values[order])):
        raise EigenError(
            f"{n_mode} modes asked for, {np.count_nonzero(finite)} have a finite frequency"
        )
    return X[:, order]


def _checked(K: sp.csr_matrix, M: sp.csr_matrix, X: Array) -> tuple[Array, Array]:
    """Ritz pairs of the span of X, ascending, after a check of their residuals."""
    X = X / np.sqrt(np.einsum("ni,ni->i", X, M @ X))
    values, Y = scipy.linalg.eigh(X.T @ (K @ X), X.T @ (M @ X))
    X = X @ Y
    KX, MX = K @ X, M @ X
    residual = np.linalg.norm(KX - MX * values, axis=0)
    size = np.linalg.norm(KX, axis=0) + np.abs(values) * np.linalg.norm(MX, axis=0)
    # a rigid motion has K x = 0: its residual is measured by the forces that K makes of x
    size = np.maximum(size, np.abs(K).max() * np.linalg.norm(X, axis=0) * 1e-6)
    worst = int(np.argmax(residual / size))
    if not residual[worst] <= 1e-6 * size[worst]:
        raise EigenError(
            f"residual {residual[worst] / size[worst]:.1e} of mode {worst + 1} is too large"
        )
    return values, X
