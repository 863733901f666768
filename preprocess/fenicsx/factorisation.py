"""Factorisation of symmetric matrices: singular ones are found, negative eigenvalues counted.

The module also has the conversion of sparse matrices from SciPy and the options of MUMPS."""

import weakref
from contextlib import suppress
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import REGULAR, Array
from .libraries import HAS_MUMPS, FactorisationError, InertiaError, PETSc, SingularError
from .team import ALONE, Distribution, Team

# For matrices of sections and shells approximate minimum degree takes half the time of nested
# dissection, with the same fill-in, as minimum fill does for larger ones: 1.0 instead of 2.2 s with
# its factorisation, for a shell of 300 000 unknowns. The ordering is what processes cannot share.
# Where unknowns fill a volume, MUMPS selects the ordering of large matrices.
MINIMUM_DEGREE, MINIMUM_FILL, AUTOMATIC = 0, 2, 7
LARGE = 100_000
VERY_LARGE = 1_000_000
PREFIX = "plymotion_mumps_"

PETSC_ERRORS = (PETSc.Error, SystemError)  # slepc4py wraps the first in the second on some builds


def reason(error: BaseException) -> str:
    """The last line of PETSc's message; the lines before it are the call stack."""
    return str(error.__cause__ or error).strip().splitlines()[-1]


def destroy(*objects: Any) -> None:
    """Destroy PETSc objects; the processes of a team must do this at the same time.

    Since 3.18, PETSc keeps objects that Python has dropped, until `destroy_dropped`. Some versions
    also keep an object because a getter of a part creates another reference.
    """
    for one in objects:
        # after a failed iteration PETSc refuses; the error of the iteration is the one to tell
        with suppress(*PETSC_ERRORS):
            one.destroy()


def destroy_dropped(team: Team) -> None:
    """Destroy objects that Python has dropped on all processes of a team."""
    cleanup = getattr(PETSc, "garbage_cleanup", None)  # PETSc 3.18 and later
    if cleanup is not None:
        cleanup(team.comm)


def sorted_csr(A: Any) -> sp.csr_matrix:
    """A in compressed rows with ascending columns, as needed for the comparison of patterns."""
    A = sp.csr_matrix(A, dtype=np.float64)
    if not A.has_sorted_indices:
        A = A.sorted_indices()
    return A


def use_mumps(pc: Any, n_dof: int, solid: bool = False, counts: bool = False) -> None:
    """Use MUMPS for the factorisation of a preconditioner, if PETSc has it.

    Parameters
    ----------
    pc : preconditioner of PETSc
    n_dof : number of unknowns, by which the ordering is chosen
    solid : the unknowns fill a volume, not a surface
    counts : negative pivots will be asked for, which MUMPS does not count in a last front that
        processes share
    """
    if not HAS_MUMPS:
        return
    ordering = MINIMUM_DEGREE if n_dof < LARGE else MINIMUM_FILL
    options = PETSc.Options()  # PETSc 3.18 ignores settings of the factor
    options[f"{PREFIX}mat_mumps_icntl_7"] = (
        ordering if n_dof < (LARGE if solid else VERY_LARGE) else AUTOMATIC
    )
    options[f"{PREFIX}mat_mumps_icntl_13"] = int(counts)
    options[f"{PREFIX}mat_mumps_icntl_27"] = 64  # right-hand sides at once: 7 % faster than 32
    pc.setOptionsPrefix(PREFIX)
    pc.setFactorSolverType("mumps")


LARGEST_GROWTH = 1.0 / REGULAR


class RandomLoad:
    """A random load; its solution shows whether the matrix is regular.

    Attributes
    ----------
    load : (n,) right-hand side to solve for
    """

    def __init__(self, diagonal: Array) -> None:
        """`diagonal` (n,) of the matrix."""
        self._scale = np.sqrt(np.abs(diagonal))
        self._z = np.random.default_rng(0).standard_normal(len(diagonal))
        self.load: Array = self._scale * self._z

    def is_regular(self, solution: Array) -> bool:
        """True if the matrix that gave this solution (n,) of the load is regular."""
        return self.growth(solution) < LARGEST_GROWTH

    def growth(self, solution: Array) -> float:
        """Size of the scaled solution (n,) over that of the load."""
        return float(np.linalg.norm(self._scale * solution) / np.linalg.norm(self._z))


def negative_pivots(A: Any, team: Team = ALONE, solid: bool = False) -> int:
    """Number of negative eigenvalues of a sparse symmetric matrix (Sylvester's law of inertia).

    With A = K - s M this counts the eigenvalues of K x = lambda M x below s, and so detects modes
    that an iteration has missed.

    Parameters
    ----------
    A : (n, n) of this process; the matrix is the sum over the team
    team : processes that share the matrix
    solid : the unknowns fill a volume, not a surface

    Raises
    ------
    InertiaError
        A cannot be factorised.
    """
    A = sorted_csr(A)
    mat = Distribution(team, A).matrix(A, spd=False)
    pc = PETSc.PC().create(comm=team.comm)
    pc.setOperators(mat)
    pc.setType("cholesky")
    use_mumps(pc, mat.getSize()[0], solid, counts=True)
    held = [pc, mat]
    try:
        pc.setUp()
        factor = pc.getFactorMatrix()
        held.append(factor)
        if not HAS_MUMPS:
            return int(factor.getInertia()[0])
        status = int(factor.getMumpsInfog(1))  # PETSc raises only for some of its errors
        if status < 0:
            raise InertiaError(f"the matrix cannot be factorised (MUMPS status {status})")
        return int(factor.getMumpsInfog(12))
    except PETSC_ERRORS as error:
        raise InertiaError(f"the matrix cannot be factorised: {reason(error)}") from error
    finally:
        destroy(*held)


class Cholesky:
    """A factorised symmetric matrix, positive definite by default.

    `update` reuses the symbolic part.

    A team of processes factorises together the sum of the matrices that each of them has, and has
    the same right-hand sides and solutions on each. The first solve after a factorisation checks it
    with an additional column. The memory of the factors is freed with the object, or earlier by
    `close`.
    """

    def __init__(
        self,
        A: Any,
        team: Team = ALONE,
        largest_growth: float = LARGEST_GROWTH,
        solid: bool = False,
        definite: bool = True,
    ) -> None:
        """`definite` is False for a matrix that may have negative eigenvalues."""
        A = sorted_csr(A)
        destroy_dropped(team)
        self.largest_growth, self._solid, self._definite = largest_growth, solid, definite
        self.growth = 0.0  # of a random load, by the last factorisation that was checked
        self.A = sp.csr_matrix((A.data.copy(), A.indices, A.indptr), shape=A.shape)
        self._team = team
        self._checked = False
        self._held: list[Any] = []
        if team.size == 1:  # the processes of a team must destroy at the same time
            weakref.finalize(self, lambda held: destroy(*held), self._held).atexit = False
        self._create()
        self._factorise()

    def update(self, A: Any) -> None:
        """Factorise another matrix of exactly the same sparsity pattern."""
        A = sorted_csr(A)
        same = np.array_equal(A.indptr, self.A.indptr) and np.array_equal(A.indices, self.A.indices)
        if not same:
            raise FactorisationError("update() needs a matrix of the same sparsity pattern")
        different = np.array([0.0 if np.array_equal(self.A.data, A.data) else 1.0])
        if self._checked and not self._team.total(different).any():
            return
        self.A.data[:] = A.data
        if self._team.size == 1:
            self._mat.stateIncrease()
        else:  # sums of parts have no zeros, so that the pattern may be another
            self.close()
            self._create()
        self._factorise()

    def solve(self, B: Array) -> Array:
        """Solve A X = B for one (n,) or several (n, k) right-hand sides.

        Raises FactorisationError if the matrix is singular.
        """
        columns = np.asarray(B, dtype=np.float64).reshape(self.A.shape[0], -1)
        if self._checked:
            return self._solve(columns).reshape(np.shape(B))
        diagonal = np.abs(self._team.total(self.A.diagonal()))
        random = RandomLoad(diagonal)
        columns = np.asfortranarray(np.column_stack([columns, random.load]))
        X = self._solve(columns)
        self.growth = random.growth(X[:, -1])
        if not self.growth < self.largest_growth:
            raise SingularError(
                f"the matrix is singular (scaled condition above {self.largest_growth:.0e}): "
                "is every rigid motion constrained and every part connected?"
            )
        self._check_residual(X, columns, float(diagonal.max()))
        self._checked = True
        return X[:, :-1].reshape(np.shape(B))

    def check(self) -> None:
        """Check the factorisation now, and measure the growth, unless this was done before."""
        if not self._checked:
            self.solve(np.empty((self.A.shape[0], 0)))

    def close(self) -> None:
        """Free the memory of the factors; no further solves are possible."""
        destroy(*self._held)

    def _create(self) -> None:
        """The objects of PETSc that new values do not change."""
        self._rows = Distribution(self._team, self.A)
        self._mat = self._rows.matrix(self.A, spd=self._definite)
        self._pc = PETSc.PC().create(comm=self._team.comm)
        self._pc.setOperators(self._mat)
        self._pc.setType("cholesky")
        use_mumps(self._pc, self.A.shape[0], self._solid)
        if not HAS_MUMPS:
            self._pc.setFactorOrdering(ord_type="nd")
        self._factor = PETSc.Mat()
        self._held[:] = self._factor, self._pc, self._mat

    def _factorise(self) -> None:
        try:
            self._pc.setUp()
        except PETSC_ERRORS as error:
            raise FactorisationError(f"the matrix cannot be factorised: {reason(error)}") from error
        destroy(self._factor)  # a reference; PETSc may have made a new factor
        self._factor = self._held[0] = self._pc.getFactorMatrix()
        if HAS_MUMPS:
            status = self._factor.getMumpsInfog(1)
            negative = self._factor.getMumpsInfog(12)
            if status < 0 or (negative > 0 and self._definite):
                raise FactorisationError(
                    f"the matrix is not positive definite (MUMPS: {negative} negative pivots, "
                    f"status {status}): is every rigid motion constrained?"
                )
        self._checked = False

    def _check_residual(self, X: Array, columns: Array, norm: float) -> None:
        """`norm` is the largest entry of the matrix."""
        residual = np.abs(self._team.total(self.A @ X) - columns).max(axis=0)
        size = norm * np.abs(X).max(axis=0) + np.abs(columns).max(axis=0)
        if not np.all(residual <= 1e-10 * size):
            raise FactorisationError(
                f"backward error {np.max(residual / size):.1e} of a Cholesky solve; the matrix is "
                "singular or indefinite: is every rigid motion constrained?"
            )

    def _solve(self, columns: Array) -> Array:
        comm, count = self._team.comm, columns.shape[1]
        own = np.asfortranarray(columns[self._rows.rows])
        size = ((len(own), len(columns)), (PETSc.DECIDE, count))
        rhs = PETSc.Mat().createDense(size, array=own, comm=comm)
        rhs.assemble()
        solution = np.zeros_like(own)
        out = PETSc.Mat().createDense(size, array=solution, comm=comm)
        out.assemble()
        self._factor.matSolve(rhs, out)
        destroy(rhs, out)
        return self._rows.gathered(solution)


def cholesky(
    A: Any, team: Team = ALONE, largest_growth: float = LARGEST_GROWTH, solid: bool = False
) -> Cholesky:
    """Factorise a symmetric positive definite sparse matrix (MUMPS where PETSc has it).

    Parameters
    ----------
    A : (n, n) of this process; the matrix is the sum over the team
    team : processes that share the matrix; each has all columns to solve for
    largest_growth : of the solution of a random load in a regular matrix
    solid : the unknowns fill a volume, not a surface

    Raises
    ------
    FactorisationError
        The matrix is indefinite or singular.
    """
    factor = Cholesky(A, team, largest_growth, solid)
    factor.check()
    return factor
