"""6x6 matrices of sections that a user gives."""

from typing import Annotated

import numpy as np
from pydantic import AfterValidator

from ...math.definite import is_positive_definite

SYMMETRY = 1e-6  # of sqrt(A_ii A_jj): matrices may be given to six digits
Rows = list[list[float]]


def _symmetric(rows: Rows) -> Rows:
    """Return a symmetric 6x6; raises ValueError for another one."""
    if [len(row) for row in rows] != [6] * 6:
        raise ValueError("expected six rows of six numbers")
    matrix = np.array(rows)
    size = np.sqrt(np.abs(np.diagonal(matrix)))
    gap = np.abs(matrix - matrix.T) - SYMMETRY * np.outer(size, size)
    if gap.max() > 0.0:
        i, j = (int(k) for k in np.unravel_index(np.argmax(gap), gap.shape))
        raise ValueError(
            f"expected a symmetric matrix, found {matrix[i, j]:g} in row {i + 1}, column {j + 1} "
            f"and {matrix[j, i]:g} in row {j + 1}, column {i + 1}"
        )
    even: Rows = (0.5 * (matrix + matrix.T)).tolist()
    return even


def _definite(rows: Rows) -> Rows:
    if not is_positive_definite(np.array(rows)):
        raise ValueError("expected a positive definite matrix")
    return rows


Symmetric = Annotated[Rows, AfterValidator(_symmetric)]
Stiffness = Annotated[Symmetric, AfterValidator(_definite)]
