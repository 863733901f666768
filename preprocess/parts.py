"""A matrix that is the sum of parts, one for each process of a team."""

from typing import Any

import scipy.sparse as sp

from ..solver.math.arrays import Array


class Part:
    """The part of a matrix that this process has.

    Products with dense arrays and the diagonal are those of the sum, on all processes. What is
    linear gives parts, so that T' A T of a sparse T is a part again.
    """

    __array_ufunc__ = None  # NumPy leaves operators to this class

    def __init__(self, own: sp.csr_matrix, team: Any) -> None:
        self.own, self.team, self.shape = own, team, own.shape

    def _of(self, product: Any) -> Any:
        return (
            Part(product.tocsr(), self.team) if sp.issparse(product) else self.team.total(product)
        )

    def __matmul__(self, other: Any) -> Any:
        return self._of(self.own @ other)

    def __rmatmul__(self, other: Any) -> Any:
        return self._of(other @ self.own)

    def __rmul__(self, factor: float) -> "Part":
        return Part(factor * self.own, self.team)

    def __add__(self, other: "Part") -> "Part":
        return Part(self.own + other.own, self.team)

    def __sub__(self, other: "Part") -> "Part":
        return Part(self.own - other.own, self.team)

    def __getitem__(self, key: Any) -> "Part":
        return Part(self.own[key], self.team)

    def __abs__(self) -> "Part":
        """Its sum is a bound of the absolute values of the sum."""
        return Part(abs(self.own), self.team)

    def diagonal(self) -> Array:
        """Diagonal of the sum."""
        return self._of(self.own.diagonal())

    def tocsr(self) -> "Part":
        """Itself."""
        return self

    def whole(self) -> sp.csr_matrix:
        """The sum, on all processes: for small matrices."""
        return sp.csr_matrix(sum(self.team.comm.allgather(self.own)))


def own(A: Any) -> Any:
    """The part of a sum that this process has; a matrix itself."""
    return A.own if isinstance(A, Part) else A
