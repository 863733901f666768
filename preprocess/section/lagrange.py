"""Lagrange functions on a reference cell, correct to the last digit.

The rounding errors of such a table are the same in all cells, so that they add up. Those of a table
by basix, 1e-15, differ with the kernel of the linear algebra and change the shear stiffness of a
strip with t/w = 1e-5 by 3e-6. Here the functions are computed with extended precision, where the
machine has it, and rounded once.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ...solver.math.arrays import Array
from .. import fenicsx

Extended = NDArray[np.floating[Any]]
REFINEMENTS = 3  # of an inverse in double precision; each one squares its error


def basis(cell: str, degree: int, points: Array) -> tuple[Array, Array]:
    """Lagrange functions of the nodes `fenicsx.reference_nodes` at points of the reference cell.

    Values (q, k) and derivatives (q, k, 2) of the k functions of a cell, in the order of its nodes.
    """
    to_nodes = _of_polynomials(cell, degree)
    of_x, of_y = (_powers(points[:, a], degree) for a in (0, 1))
    pairs = _pairs(cell, degree)
    tables = [
        np.stack([x[i] * y[j] for i, j in pairs], axis=1) @ to_nodes
        for x, y in ((of_x[0], of_y[0]), (of_x[1], of_y[0]), (of_x[0], of_y[1]))
    ]
    values, by_x, by_y = (table.astype(np.float64) for table in tables)
    slopes: Array = np.stack([by_x, by_y], axis=-1)
    return values, slopes


def _pairs(cell: str, degree: int) -> list[tuple[int, int]]:
    """Degrees in x and y of the polynomials of a cell: complete, or the products of all."""
    every = range(degree + 1)
    return [(i, j) for i in every for j in every if cell != "triangle" or i + j <= degree]


def _powers(x: Array, degree: int) -> tuple[Extended, Extended]:
    """Legendre polynomials on (0, 1) and their derivatives, (degree + 1, q) each."""
    along = 2 * np.asarray(x, dtype=np.longdouble) - 1
    values = legendre.legvander(along, degree)
    one = np.eye(degree + 1, dtype=np.longdouble)
    slopes = [2 * legendre.legval(along, legendre.legder(one[i])) for i in range(degree + 1)]
    return values.T, np.array(slopes)


@lru_cache(maxsize=32)
def _of_polynomials(cell: str, degree: int) -> Extended:
    """Coefficients (k, k) of the Lagrange functions, as columns, in the Legendre polynomials."""
    nodes = fenicsx.reference_nodes(cell, degree)
    x, y = (_powers(nodes[:, a], degree)[0] for a in (0, 1))
    at_nodes = np.stack([x[i] * y[j] for i, j in _pairs(cell, degree)], axis=1)
    inverse = np.linalg.inv(at_nodes.astype(np.float64)).astype(np.longdouble)
    for _ in range(REFINEMENTS):  # Newton's iteration of an inverse (Schulz 1933)
        inverse = inverse @ (2 * np.eye(len(nodes), dtype=np.longdouble) - at_nodes @ inverse)
    return inverse
