"""Sparse matrices between SciPy and PETSc."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from .stack import MPI, PETSc

PETSC_ERRORS = (PETSc.Error, SystemError)  # slepc4py wraps the first in the second on some builds


def reason(error: BaseException) -> str:
    """The last line of PETSc's message: the lines before it are its call stack."""
    return str(error.__cause__ or error).strip().splitlines()[-1]


def petsc_matrix(A: sp.csr_matrix, *, spd: bool) -> Any:
    """A PETSc matrix of this process only, with what is known of it."""
    index = PETSc.IntType
    mat = PETSc.Mat().createAIJ(
        size=A.shape,
        csr=(A.indptr.astype(index), A.indices.astype(index), A.data),
        comm=MPI.COMM_SELF,
    )
    mat.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    if spd:
        mat.setOption(PETSc.Mat.Option.SPD, True)  # MUMPS then runs with SYM=1, half an LU
    return mat


def sorted_csr(A: Any) -> sp.csr_matrix:
    """A in compressed rows with ascending columns, as the comparison of patterns needs it."""
    A = sp.csr_matrix(A, dtype=np.float64)
    if not A.has_sorted_indices:
        A = A.sorted_indices()
    return A
