"""A mesh as plain arrays, before conversion to DOLFINx, and its reference cells.

Basix gives points of integration, nodes and functions of the reference cells."""

from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...solver.math.arrays import Array, IntArray
from . import libraries

# Ends of the edges of a cell, counter-clockwise.
EDGES = {
    "triangle": np.array([[0, 1], [1, 2], [2, 0]]),
    "quadrilateral": np.array([[0, 1], [1, 2], [2, 3], [3, 0]]),
}
# Positions of the nodes of a degree-2 cell in gmsh's order, in halves of the reference cell:
# corners, middles of the edges, centre. A degree-1 cell has only the corners.
NODES = {
    "triangle": np.array([[0, 0], [2, 0], [0, 2], [1, 0], [1, 1], [0, 1]]),
    "quadrilateral": np.array(
        [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]]
    ),
}


class NamedNodes(NamedTuple):
    """Nodes by their number in gmsh and by physical curve and point; -1 is a node without cells."""

    tags: IntArray  # (n,) number of each point in gmsh
    curves: dict[str, IntArray]  # (s, 2 or 3) rows of points: ends, then the middle
    points: dict[str, IntArray]  # (k,) rows of points


@dataclass(frozen=True)
class PlainMesh:
    """Cells of one kind, each in one region; `n` counts nodes, `c` cells, `k` nodes of a cell.

    The order of the nodes of a cell is gmsh's: corners, middles of the edges, centre. A mesh of
    triangles and quadrilaterals is "mixed": k = 4, and triangles have -1 as fourth node. It is
    not converted to DOLFINx.
    """

    points: Array  # (n, 2 or 3) [m]
    cells: IntArray  # (c, k) rows of points
    cell: str  # "triangle", "quadrilateral" or "mixed"
    degree: int  # of the geometry, 1 or 2
    region: IntArray  # (c,) row of regions
    regions: tuple[str, ...]
    # physical curve -> (s, 2 or 3, 2 or 3) line elements: end points, then the middle node [m]
    curves: dict[str, Array] = field(default_factory=dict)
    named: NamedNodes | None = None  # of a mesh from gmsh


def with_centre_nodes(points: Array, cells: IntArray) -> tuple[Array, IntArray]:
    """Eight-node quadrilaterals as nine-node ones of the same shape.

    The eight functions of the cell give the centre node, so that the map of the cell does not
    change. Returns points and cells (c, 9).
    """
    nodes = points[cells]
    centres = 0.5 * nodes[:, 4:8].sum(axis=1) - 0.25 * nodes[:, :4].sum(axis=1)
    number = len(points) + np.arange(len(cells))
    return np.concatenate([points, centres]), np.concatenate([cells, number[:, None]], axis=1)


def used_nodes(points: Array, cells: IntArray) -> tuple[Array, IntArray]:
    """Points that cells refer to, and the cells in their numbering."""
    used, number = np.unique(cells, return_inverse=True)
    return points[used], number.reshape(cells.shape)


def quadrature(cell: str, degree: int) -> tuple[Array, Array]:
    """Points (q, 2) and weights (q,) on the reference cell, exact for polynomials of `degree`."""
    points, weights = libraries.basix.make_quadrature(
        getattr(libraries.basix.CellType, cell), degree
    )
    return np.array(points), np.array(weights)


def reference_nodes(cell: str, degree: int) -> Array:
    """Positions of the nodes of Lagrange functions on the reference cell, (k, dim)."""
    return np.array(_lagrange(cell, degree).points)


def lagrange(cell: str, degree: int, points: Array) -> tuple[Array, Array]:
    """Values (q, k) and derivatives (q, k, dim) of the k Lagrange functions of a reference cell.

    Parameters
    ----------
    cell : its kind, such as "triangle"
    degree : of the functions, in the order of `reference_nodes`
    points : (q, dim) of the reference cell
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
    return libraries.basix.create_element(
        libraries.basix.ElementFamily.P,
        getattr(libraries.basix.CellType, cell),
        degree,
        libraries.basix.LagrangeVariant.gll_warped,
    )
