"""Solvers of the reduction of a solid: factors by MUMPS, or conjugate gradients with two grids."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from .. import fenicsx
from ..exchange.links import Constrained
from ..fenicsx import PlainMesh
from .cells import CORNERS, linear_weights


class Mumps:
    """Direct solver of a reduction by MUMPS and SLEPc, see exchange/direct.py."""

    counts = True

    def __init__(self, parts: Constrained) -> None:
        del parts  # MUMPS orders by the pattern of the matrix
        self._last: tuple[Any, Any] | None = None

    def add_subset(self, kept: IntArray) -> None:
        """Systems in fewer unknowns will come."""

    def solve(self, A: Any, B: Array) -> Array:
        """Solve A X = B; factors of the same A are used again."""
        if self._last is None or self._last[0] is not A:
            self._last = A, fenicsx.cholesky(A, solid=True)
        return np.asarray(self._last[1].solve(B))

    def negative_pivots(self, A: Any) -> int:
        """Number of negative eigenvalues of A. Raises ArithmeticError if A is singular."""
        try:
            return fenicsx.negative_pivots(A, solid=True)
        except fenicsx.InertiaError as error:
            raise ArithmeticError(str(error)) from error

    def eigenpairs(self, K: Any, M: Any, count: int) -> tuple[Array, Array]:
        """Lowest values (count,) and vectors of K x = value M x."""
        self._last = None
        return fenicsx.eigenpairs(K, M, count, solid=True)


class Iterative:
    """Solver with the memory of the matrices: the coarse unknowns are those of the corners.

    It cannot count eigenvalues, which needs factors.
    """

    counts = False

    def __init__(self, plain: PlainMesh, parts: Constrained) -> None:
        P = _from_corners(plain, parts)
        self._P = {P.shape[0]: P}
        self._last: tuple[Any, Any] | None = None

    def add_subset(self, kept: IntArray) -> None:
        """Systems in fewer unknowns will come."""
        (P,) = self._P.values()
        some = sp.csc_matrix(P[kept])
        self._P[len(kept)] = some[:, np.diff(some.indptr) > 0]

    def solve(self, A: Any, B: Array) -> Array:
        """Solve A X = B; what is prepared for the same A is used again."""
        return np.asarray(self._grids(A).solve(B))

    def negative_pivots(self, A: Any) -> int:
        """Not possible without factors."""
        raise ArithmeticError(f"{A.shape[0]} unknowns are not factorised")

    def eigenpairs(self, K: Any, M: Any, count: int) -> tuple[Array, Array]:
        """Lowest values (count,) and vectors of K x = value M x."""
        return self._grids(K).eigenpairs(M, count)

    def _grids(self, A: Any) -> Any:
        if self._last is None or self._last[0] is not A:
            if self._last is not None:
                self._last[1].close()
            self._last = A, fenicsx.TwoGrids(A, self._P[A.shape[0]])
        return self._last[1]


def _from_corners(plain: PlainMesh, parts: Constrained) -> sp.csr_matrix:
    """Independent unknowns from those at corners and of rigid interfaces, linear in each cell."""
    n, vertices = len(plain.points), CORNERS[plain.cell]
    W = linear_weights(plain.cell)  # (nodes, corners)
    node, corner = np.nonzero(W)
    pairs = plain.cells[:, node] * n + plain.cells[:, corner]
    places, first = np.unique(pairs, return_index=True)
    values = np.tile(W[node, corner], len(plain.cells))[first]
    nodal = sp.csr_matrix((values, np.divmod(places, n)), (n, n))
    T = sp.csc_matrix(parts.T)
    loose = T.shape[1] - 6 * len(parts.reference_dofs)
    dof = T.indices[T.indptr[:loose]]  # the only entry of its column
    coarse = np.isin(dof // 3, plain.cells[:, :vertices])
    columns = np.concatenate([np.flatnonzero(coarse), np.arange(loose, T.shape[1])])
    full = sp.kron(nodal, sp.eye(3), format="csr")[dof] @ T[:, columns]
    references = sp.eye(T.shape[1], format="csr")[loose:][:, columns]
    return sp.csr_matrix(sp.vstack([full, references]))
