"""Eigenpairs of large sparse matrices by SLEPc."""

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from ...solver.math.arrays import is_positive_definite
from .factorisation import PETSC_ERRORS, RandomLoad, destroy, reason, sorted_csr, use_mumps
from .libraries import HAS_MUMPS, Array, EigenError, PETSc, SLEPc
from .team import ALONE, Distribution, Team, whole


def eigenpairs(
    K: Any,
    M: Any,
    n_mode: int,
    *,
    target: float = 0.0,
    tolerance: float = 1e-12,
    team: Team = ALONE,
    solid: bool = False,
) -> tuple[Array, Array]:
    """Eigenpairs of K x = lambda M x nearest to `target`, ascending and M-orthonormal.

    Parameters
    ----------
    K : (n, n) symmetric sparse; K - target M must be regular. Positive definite at target 0;
        a body that is free to move needs a negative target.
    M : (n, n) symmetric positive semi-definite sparse (lumped masses without rotary inertia are
        allowed: massless directions have no eigenpair and are omitted).
    n_mode : number of pairs, up to the number of finite eigenvalues
    target : shift of the shift-and-invert transformation, in the unit of lambda
    tolerance : relative tolerance of the Krylov-Schur iteration
    team : processes that have parts of K and M and share the work; each gets all pairs
    solid : the unknowns fill a volume, not a surface

    Returns
    -------
    (n_mode,) eigenvalues and (n, n_mode) vectors with X' M X = I. Signs are SLEPc's.

    Raises
    ------
    EigenError : more pairs requested than exist, K singular at target 0, too few converged, or a
        residual too large.
    """
    K, M = sorted_csr(K), sorted_csr(M)
    n_dof = K.shape[0]
    # a row of M without an entry has no mass and gives one infinite eigenvalue
    n_finite = int(np.count_nonzero(team.total(np.asarray(np.abs(M).sum(axis=1)))))
    if not 1 <= n_mode <= n_finite:
        raise EigenError(
            f"{n_mode} modes requested: the problem of {n_dof} unknowns has {n_finite} of finite "
            "frequency"
        )
    n_krylov = max(2 * n_mode, n_mode + 15)
    if n_krylov + 5 >= n_finite:  # the Krylov space would be the whole space
        K, M, team = whole(K, team), whole(M, team), ALONE
        X = _dense(K, M, n_mode, target)
        try:
            return checked(K, M, X, team)
        except EigenError:
            return checked(K, M, _sharpened(K, M, X), team)
    # SLEPc can solve once more for every vector, which removes errors that a singular M amplifies
    for purify in (False, True) if n_finite == n_dof else (True,):
        X = _krylov_schur(K, M, n_mode, n_krylov, target, tolerance, team, purify, solid)
        try:
            return checked(K, M, X, team)
        except EigenError as error:
            failed = error
    raise failed


def _krylov_schur(
    K: sp.csr_matrix,
    M: sp.csr_matrix,
    n_mode: int,
    n_krylov: int,
    target: float,
    tolerance: float,
    team: Team,
    purify: bool,
    solid: bool,
) -> Array:
    n_dof, rows = K.shape[0], Distribution(team, K, M)
    eps = SLEPc.EPS().create(comm=team.comm)
    operators = rows.matrix(K, spd=target == 0.0), rows.matrix(M, spd=False)
    eps.setOperators(*operators)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(target)
    eps.setDimensions(nev=n_mode, ncv=n_krylov)
    eps.setTolerances(tol=tolerance, max_it=500)
    eps.setPurify(purify)
    transformation = eps.getST()
    transformation.setType(SLEPc.ST.Type.SINVERT)
    transformation.setShift(target)
    ksp = transformation.getKSP()
    ksp.setType("preonly")
    pc = ksp.getPC()
    # PETSc's own Cholesky does not pivot: use an LU for an indefinite matrix
    pc.setType("cholesky" if HAS_MUMPS or target <= 0.0 else "lu")
    use_mumps(pc, n_dof, solid)
    start = PETSc.Vec().createMPI((rows.n_own, n_dof), comm=team.comm)
    own = np.random.default_rng(0).standard_normal(n_dof)[rows.rows]  # runs must reproduce
    start.setArray(own)
    eps.setInitialSpace([start])
    load, vector = start.duplicate(), start.duplicate()
    try:
        eps.setUp()
        # with a shift away from zero the factorised matrix is as far from singular as the
        # eigenvalues require; K alone must be definite
        if target == 0.0:
            random = RandomLoad(team.total(K.diagonal()))
            load.setArray(random.load[rows.rows])
            ksp.solve(load, vector)
            if not random.is_regular(rows.gathered(vector.getArray())):
                raise EigenError(_singular(target, "it is singular"))
        eps.solve()
        n_converged = eps.getConverged()
        if n_converged < n_mode:
            raise EigenError(
                f"{n_converged} of {n_mode} modes converged in {eps.getIterationNumber()} "
                f"iterations (tolerance {tolerance:g})"
            )
        X = np.empty((rows.n_own, n_mode))
        for i in range(n_mode):
            eps.getEigenvector(i, vector)
            X[:, i] = vector.getArray()
        return rows.gathered(X)
    except PETSC_ERRORS as error:
        raise EigenError(_singular(target, reason(error))) from error
    finally:
        destroy(start, load, vector, pc, ksp, transformation, eps, *operators)


def _singular(target: float, why: str) -> str:
    matrix = f"K - ({target:g}) M" if target else "K"
    return (
        f"{matrix} cannot be factorised ({why}): is the body free to move? "
        "A negative target is needed then"
    )


def _dense(K: sp.csr_matrix, M: sp.csr_matrix, n_mode: int, target: float) -> Array:
    # M may be singular but K - shift M is not, so the inverse pencil is used. Above the lowest
    # eigenvalue the shifted matrix is indefinite, so a positive target is ignored here.
    shift = min(target, 0.0)
    shifted = (K - shift * M).toarray()
    if shift == 0.0 and not is_positive_definite(shifted):
        raise EigenError(_singular(shift, "it is not positive definite"))
    try:
        inverse, X = scipy.linalg.eigh(M.toarray(), shifted)
    except scipy.linalg.LinAlgError as error:
        raise EigenError(_singular(shift, "it is not positive definite")) from error
    finite = inverse > len(inverse) * np.finfo(float).eps * inverse[-1]
    values = np.full_like(inverse, np.inf)
    values[finite] = shift + 1.0 / inverse[finite]
    order = np.argsort(np.abs(values - target), kind="stable")[:n_mode]
    if not np.all(np.isfinite(values[order])):
        raise EigenError(
            f"{n_mode} modes requested, {np.count_nonzero(finite)} have a finite frequency"
        )
    return X[:, order]


def _sharpened(K: sp.csr_matrix, M: sp.csr_matrix, X: Array) -> Array:
    """A step of inverse iteration with the Rayleigh quotient of each vector.

    High modes of the inverse pencil have few digits if the lowest eigenvalue is 1e-12 of theirs,
    as that of a long thin beam.
    """
    K, M = K.toarray(), M.toarray()
    vectors = []
    for x in X.T:
        load = M @ x
        shifted = K - (x @ K @ x) / (x @ load) * M
        try:
            y = np.linalg.solve(shifted, load)  # nearly singular, along the wanted vector
        except np.linalg.LinAlgError:
            y = x  # an eigenvector to the last digit
        vectors.append(y / np.linalg.norm(y))
    return np.column_stack(vectors)


def checked(K: sp.csr_matrix, M: sp.csr_matrix, X: Array, team: Team) -> tuple[Array, Array]:
    """Ritz pairs of the span of X, ascending, after a check of their residuals.

    Parameters
    ----------
    K, M : (n, n) stiffness and mass, of the cells of this process
    X : (n, k) approximate vectors, whole on every process
    team : processes that share the cells

    Raises
    ------
    EigenError
        A residual above 1e-6 of the forces.
    """
    X = X / np.sqrt(np.einsum("ni,ni->i", X, team.total(M @ X)))
    values, Y = scipy.linalg.eigh(X.T @ team.total(K @ X), X.T @ team.total(M @ X))
    X = X @ Y
    KX, MX = team.total(K @ X), team.total(M @ X)
    residual = np.linalg.norm(KX - MX * values, axis=0)
    size = np.linalg.norm(KX, axis=0) + np.abs(values) * np.linalg.norm(MX, axis=0)
    # a rigid motion has K x = 0: its residual is relative to the forces that K gives for x
    size = np.maximum(
        size, np.abs(team.total(K.diagonal())).max() * np.linalg.norm(X, axis=0) * 1e-6
    )
    worst = int(np.argmax(residual / size))
    if not residual[worst] <= 1e-6 * size[worst]:
        raise EigenError(
            f"residual {residual[worst] / size[worst]:.1e} of mode {worst + 1} is too large"
        )
    return values, X
