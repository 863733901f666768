"""Quadrature, nodes and functions of reference cells, by Basix alone."""

from functools import cache
from typing import Any

import numpy as np

from ...solver.math.arrays import Array
from .plain import NODES
from .stack import basix


def quadrature(cell: str, degree: int) -> tuple[Array, Array]:
    """Points (q, 2) and weights (q,) on the reference cell, exact for polynomials of `degree`."""
    points, weights = basix.make_quadrature(getattr(basix.CellType, cell), degree)
    return np.array(points), np.array(weights)


def reference_nodes(cell: str, degree: int) -> Array:
    """Positions of the nodes of Lagrange functions on the reference cell, (k, dim)."""
    return np.array(_lagrange(cell, degree).points)


def lagrange(cell: str, degree: int, points: Array) -> tuple[Array, Array]:
    """Lagrange functions of the nodes `reference_nodes` at points (q, dim) of the reference cell.

    Values (q, k) and derivatives (q, k, dim) of the k functions.
    """
    table = _lagrange(cell, degree).tabulate(1, points)
    table = table.reshape(len(table), len(points), -1)  # some versions have a fourth axis
    return np.array(table[0]), np.moveaxis(table[1:], 0, -1).copy()


@cache
def order_of_nodes(cell: str) -> list[int]:
    """Row in `reference_nodes` of each of the 6 or 9 nodes of `NODES`."""
    places = np.rint(2.0 * reference_nodes(cell, 2)).astype(int).tolist()
    return [places.index(place) for place in NODES[cell].tolist()]


@cache
def _lagrange(cell: str, degree: int) -> Any:
    return basix.create_element(
        basix.ElementFamily.P,
        getattr(basix.CellType, cell),
        degree,
        basix.LagrangeVariant.gll_warped,
    )
