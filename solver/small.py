"""Products of small matrices: loops where compiled, NumPy's operator where not.

A call of the BLAS costs more than the twenty multiplications of a body's
matrices, and interpreted loops cost more than either: each side gets its own.
"""

import numpy as np

from .compiled import COMPILED, jit
from .package.schema import Array


@jit
def _looped_mv(A: Array, x: Array) -> Array:
    out = np.zeros(A.shape[0])
    for i in range(A.shape[0]):
        s = 0.0
        for j in range(A.shape[1]):
            s += A[i, j] * x[j]
        out[i] = s
    return out


@jit
def _looped_tv(A: Array, x: Array) -> Array:
    out = np.zeros(A.shape[1])
    for j in range(A.shape[0]):
        for i in range(A.shape[1]):
            out[i] += A[j, i] * x[j]
    return out


@jit
def _looped_mm(A: Array, B: Array) -> Array:
    out = np.zeros((A.shape[0], B.shape[1]))
    for i in range(A.shape[0]):
        for k in range(A.shape[1]):
            a = A[i, k]
            for j in range(B.shape[1]):
                out[i, j] += a * B[k, j]
    return out


@jit
def _looped_add(M: Array, i: int, j: int, B: Array, factor: float) -> None:
    for a in range(B.shape[0]):
        for b in range(B.shape[1]):
            M[i + a, j + b] += factor * B[a, b]


@jit
def _looped_add_transposed(M: Array, i: int, j: int, B: Array, factor: float) -> None:
    for a in range(B.shape[0]):
        for b in range(B.shape[1]):
            M[i + b, j + a] += factor * B[a, b]


def _add(M: Array, i: int, j: int, B: Array, factor: float) -> None:
    """Add factor * B to the block of M that begins at (i, j)."""
    M[i : i + B.shape[0], j : j + B.shape[1]] += factor * B


def _add_transposed(M: Array, i: int, j: int, B: Array, factor: float) -> None:
    """Add factor * B' to the block of M that begins at (i, j)."""
    M[i : i + B.shape[1], j : j + B.shape[0]] += factor * B.T


def _mv(A: Array, x: Array) -> Array:
    """Return A x."""
    return A @ x


def _tv(A: Array, x: Array) -> Array:
    """Return A' x."""
    return A.T @ x


def _mm(A: Array, B: Array) -> Array:
    """Return A B."""
    return A @ B


mv = _looped_mv if COMPILED else _mv
tv = _looped_tv if COMPILED else _tv
mm = _looped_mm if COMPILED else _mm
add = _looped_add if COMPILED else _add
add_transposed = _looped_add_transposed if COMPILED else _add_transposed
