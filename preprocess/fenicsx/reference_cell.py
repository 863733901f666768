"""Quadrature and Lagrange functions of reference cells, by Basix alone."""

from typing import Any

import numpy as np

from ...solver.math.arrays import Array
from .stack import basix


def quadrature(cell: str, degree: int) -> tuple[Array, Array]:
    """Points (q, 2) and weights (q,) on the reference cell, exact for polynomials of `degree`."""
    points, weights = basix.make_quadrature(getattr(basix.CellType, cell), degree)
    return np.array(points), np.array(weights)


def basis(cell: str, degree: int, points: Array) -> tuple[Array, Array]:
    """Lagrange functions of `vector_space` and of the geometry at points of the reference cell.

    Values (q, k) and derivatives (q, k, 2) of the k functions of a cell, in the order of
    `cell_dofs`. There DOLFINx has already ordered the nodes of shared edges consistently.
    """
    table = np.asarray(_lagrange(cell, degree).tabulate(1, points))[..., 0]
    return table[0], np.moveaxis(table[1:], 0, -1)


def reference_nodes(cell: str, degree: int) -> Array:
    """Positions of the nodes of `basis` on the reference cell, (k, 2)."""
    return np.array(_lagrange(cell, degree).points)


def _lagrange(cell: str, degree: int) -> Any:
    return basix.create_element(
        basix.ElementFamily.P,
        getattr(basix.CellType, cell),
        degree,
        basix.LagrangeVariant.gll_warped,
    )
