"""Findings on a file, and checks of arrays that report them."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import PackageError, did_you_mean
from ...math.arrays import REGULAR, Array, IntArray, smallest_eigenvalue

Reporter = Callable[[str, str], None]  # arguments: dataset and message


class Remark(NamedTuple):
    """One remark on a package."""

    level: str  # error (unusable), warning (suspicious) or note
    dataset: str
    message: str


def raise_first(path: Path, findings: list[Remark]) -> None:
    """Raise the first error among findings as PackageError, with the number of others."""
    errors = [f for f in findings if f.level == "error"]
    if errors:
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        raise PackageError(f"{path}: {errors[0].dataset}: {errors[0].message}{more}")


SYMMETRY = 1e-9  # largest |K - K'| over largest |K|
ROUNDING = 1e-13  # of the terms of a sum: largest result where they cancel
ORTHONORMAL = 1e-9  # largest entry of |A'A - 1|


def finite(path: str, value: object, error: Reporter) -> None:
    """Report the first entry that is NaN or infinite.

    Parameters
    ----------
    path : path of the dataset, for messages
    value : numbers of the dataset
    error : function that gets path and text of a finding
    """
    array = np.asarray(value)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        error(path, f"expected finite numbers, entry {list(index)} is {array[index]}")


def symmetric(path: str, matrix: Array, error: Reporter, scale: float = 0.0) -> None:
    """Report the pair of entries that differ most.

    Parameters
    ----------
    path : path of the dataset, for messages
    matrix : the matrix (n, n)
    error : function that gets path and text of a finding
    scale : size of the terms that the entries are sums of
    """
    matrix = np.asarray(matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        return  # the layout check reports it
    gap = np.abs(matrix - matrix.T)
    if gap.max() > max(SYMMETRY * np.abs(matrix).max(), ROUNDING * scale):
        i, j = (int(v) for v in np.unravel_index(np.argmax(gap), gap.shape))
        pair = f"entries [{i}, {j}] and [{j}, {i}] are {matrix[i, j]:.6g} and {matrix[j, i]:.6g}"
        error(path, f"expected a symmetric matrix, {pair}")


def positive_definite(path: str, matrix: Array, error: Reporter, size: Array | None = None) -> None:
    """Report a matrix that has an eigenvalue at or below zero, to round-off.

    `size` (n,): square roots of the diagonal by the scale of the data; see `to_unit_diagonal`.

    Parameters
    ----------
    path : path of the dataset, for messages
    matrix : the matrix (n, n)
    error : function that gets path and text of a finding
    size : square roots of the diagonal by the scale of the data (n,)
    """
    matrix = np.asarray(matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        return
    try:
        smallest = smallest_eigenvalue(matrix, size)
    except np.linalg.LinAlgError as cause:
        error(path, f"its eigenvalues cannot be computed ({cause})")
        return
    if not smallest > REGULAR:
        text = f"expected a positive definite matrix, smallest eigenvalue is {smallest:.6g}"
        error(path, f"{text} after scaling to a unit diagonal")


def one_of(path: str, values: Iterable[str], known: tuple[str, ...], error: Reporter) -> None:
    """Report every name that is not a known one.

    Parameters
    ----------
    path : path of the dataset, for messages
    values : names in the dataset
    known : names that are allowed
    error : function that gets path and text of a finding
    """
    for value in values:
        if value not in known:
            hint = did_you_mean(value, known)
            error(path, f"expected one of {', '.join(known)}, found {value!r}{hint}")


def rows_of(path: str, rows: IntArray, length: int, error: Reporter) -> None:
    """Report rows that point outside a table of `length` rows.

    Parameters
    ----------
    path : path of the dataset, for messages
    rows : numbers of rows
    length : number of rows of the table
    error : function that gets path and text of a finding
    """
    rows = np.asarray(rows)
    if len(rows) and (rows.min() < 0 or rows.max() >= length):
        error(path, f"expected rows 0 ... {length - 1}, found {rows.min()} ... {rows.max()}")


def mesh_cells(offsets: IntArray, connectivity: IntArray, n_node: int, error: Reporter) -> None:
    """Report offsets that do not divide the connectivity, and unknown nodes.

    Parameters
    ----------
    offsets : begin of each cell (c + 1,)
    connectivity : nodes of all cells, end to end
    n_node : number of nodes
    error : function that gets path and text of a finding
    """
    offsets, connectivity = np.asarray(offsets), np.asarray(connectivity)
    if len(offsets) and (
        offsets[0] != 0 or offsets[-1] != len(connectivity) or np.any(np.diff(offsets) < 0)
    ):
        error("mesh/offsets", f"expected 0 ... {len(connectivity)} in ascending order")
    rows_of("mesh/connectivity", connectivity, n_node, error)


def rotations(path: str, A: Array, error: Reporter) -> None:
    """Report a matrix (..., 3, 3) that is not a rotation.

    Parameters
    ----------
    path : path of the dataset, for messages
    A : matrices (..., 3, 3)
    error : function that gets path and text of a finding
    """
    A = np.asarray(A)
    if A.shape[-2:] != (3, 3) or not A.size:
        return
    gap = np.abs(np.swapaxes(A, -1, -2) @ A - np.eye(3)).max(axis=(-1, -2))
    bad = ~((gap < ORTHONORMAL) & (np.linalg.det(A) > 0))
    if np.any(bad):
        where = f", row {int(np.argmax(bad))} is not" if A.ndim > 2 else ""
        error(path, f"expected a rotation matrix (orthonormal, determinant +1){where}")
