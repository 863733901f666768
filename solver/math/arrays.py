"""Array types, and two questions about arrays: definiteness, and the front of points.

Definiteness is that of symmetric matrices with rows of mixed units. Scaled to a unit diagonal, the
eigenvalues are free of units, and rounding changes each of them by a few 1e-16 times the number of
rows. A singular matrix so falls below REGULAR on every processor, whatever the sign of the
rounding, and a usable one lies far above it.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Triple = tuple[float, float, float]

Memory = TypeVar("Memory")

REGULAR = 1e-13  # smallest eigenvalue of a definite matrix of unit diagonal


def distinct(*arrays: Any) -> Any:
    """Return the numbers that differ, sorted. `np.unique` alone would import numpy.ma: 10 ms."""
    return np.unique(np.concatenate(arrays, axis=None), return_index=True)[0]


def quadratic_forms(H: Array, q: Array) -> Array:
    """Return q' H_a q (k, a) of each row of q (k, m), H (a, m, m)."""
    return np.asarray(np.einsum("akj,kj->ka", q @ H, q))


def zeros_of(
    kind: Callable[..., Memory], sizes: Mapping[str, int], one: Any = 1.0, **given: Any
) -> Memory:
    """Return a NamedTuple whose arrays are zeros, in the shapes with which it annotates them.

    Parameters
    ----------
    kind : with fields such as `load: Annotated[Array, "nb, 6"]`
    sizes : numbers by the symbols of the shapes
    one : 1.0 or 1.0 + 0.0j: real or complex numbers
    given : all other fields
    """
    for name, hint in kind.__annotations__.items():
        if name not in given:
            symbols = hint.__metadata__[0].split(", ")
            shape = [int(each) if each.isdigit() else sizes[each] for each in symbols]
            given[name] = np.zeros(shape, int if hint.__origin__ == IntArray else type(one))
    return kind(**given)


def to_unit_diagonal(matrix: Array, size: Array | None = None) -> Array:
    """A_ij / (s_i s_j) with s_i = sqrt|A_ii|, (n, n).

    Parameters
    ----------
    matrix : (n, n)
    size : (n,) expected s_i. A diagonal entry below REGULAR s_i^2 is rounding: its row is then
        divided by the expected size, and the entry stays near zero.
    """
    own = np.sqrt(np.abs(np.diagonal(matrix)))
    if size is not None:
        own = np.where(own > np.sqrt(REGULAR) * size, own, size)
    own = np.where(own > 0.0, own, 1.0)
    return np.asarray(matrix / own[:, None] / own)


def smallest_eigenvalue(matrix: Array, size: Array | None = None) -> float:
    """Smallest eigenvalue of the symmetric part after scaling to a unit diagonal.

    Raises LinAlgError for numbers that are not finite. `size`: see `to_unit_diagonal`.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = to_unit_diagonal(matrix, size)
    if not np.isfinite(scaled).all():
        raise np.linalg.LinAlgError("overflow")
    return float(np.linalg.eigvalsh((scaled + scaled.T) / 2)[0])


def is_positive_definite(matrix: Array) -> bool:
    """True if the symmetric part is positive definite beyond rounding."""
    try:
        return bool(smallest_eigenvalue(matrix) > REGULAR)
    except np.linalg.LinAlgError:
        return False


def front(points: Sequence[tuple[float, float]]) -> list[int]:
    """Return the indices of the points of the Pareto front, sorted by the first number.

    Parameters
    ----------
    points : pairs of which less is better, as CPU time [s] and error
    """
    chosen: list[int] = []
    for i in sorted(range(len(points)), key=points.__getitem__):
        if not chosen or points[i][1] < points[chosen[-1]][1]:
            chosen.append(i)
    return chosen
