"""Conversion of sparse matrices between SciPy and PETSc."""

from contextlib import suppress
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..stack import HAS_MUMPS, PETSc
from ..team import Team

# For matrices of sections and shells approximate minimum degree takes half the time of nested
# dissection, with the same fill-in, as minimum fill does for larger ones: 1.0 instead of 2.2 s with
# its factorisation, for a shell of 300 000 unknowns. The ordering is what processes cannot share.
# Where unknowns fill a volume, MUMPS selects the ordering of large matrices.
MINIMUM_DEGREE, MINIMUM_FILL = 0, 2
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


def use_mumps(pc: Any, n_dof: int, solid: bool = False) -> None:
    """Use MUMPS for the factorisation of a preconditioner, if PETSc has it.

    `solid` is True where the unknowns fill a volume, not a surface.
    """
    if not HAS_MUMPS:
        return
    if n_dof < (LARGE if solid else VERY_LARGE):
        # through the options: PETSc 3.18 ignores settings of the factor
        PETSc.Options()[f"{PREFIX}mat_mumps_icntl_7"] = (
            MINIMUM_DEGREE if n_dof < LARGE else MINIMUM_FILL
        )
        pc.setOptionsPrefix(PREFIX)
    pc.setFactorSolverType("mumps")
