"""Number of negative eigenvalues of a large sparse symmetric matrix."""

from typing import Any

from .distributed import Distribution
from .errors import InertiaError
from .petsc import PETSC_ERRORS, destroy, reason, sorted_csr, use_mumps
from .stack import HAS_MUMPS, PETSc
from .team import ALONE, Team


def negative_pivots(A: Any, team: Team = ALONE, solid: bool = False) -> int:
    """Number of negative eigenvalues of a sparse symmetric matrix (Sylvester's law of inertia).

    With A = K - s M this counts the eigenvalues of K x = lambda M x below s, and so detects modes
    that an iteration has missed. Each process of a team has a part of A. Raises
    InertiaError if A cannot be factorised.
    """
    A = sorted_csr(A)
    mat = Distribution(team, A).matrix(A, spd=False)
    pc = PETSc.PC().create(comm=team.comm)
    pc.setOperators(mat)
    pc.setType("cholesky")
    use_mumps(pc, mat.getSize()[0], solid)
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
