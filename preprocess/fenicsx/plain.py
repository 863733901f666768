"""A mesh as plain arrays from gmsh or a file, before conversion to DOLFINx."""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .spaces import basis
from .stack import Array, dolfinx, gmsh_bridge

IntArray = NDArray[np.int64]

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
    named: NamedNodes | None = None  # of a mesh from gmsh, before any split

    @property
    def corners(self) -> IntArray:
        """Corner nodes of each cell, (c, 3 or 4)."""
        return self.cells[:, : len(EDGES[self.cell])]

    @property
    def middles(self) -> Array:
        """Mean of the corners of each cell, (c, 2 or 3) [m]."""
        return np.asarray(self.points[self.corners].mean(axis=1))

    @property
    def dolfinx_cells(self) -> IntArray:
        """The cells with their nodes in DOLFINx's order."""
        kind = getattr(dolfinx.mesh.CellType, self.cell)
        order = gmsh_bridge.cell_perm_array(kind, self.cells.shape[1])
        return np.ascontiguousarray(self.cells[:, order])

    def edges(self) -> tuple[IntArray, IntArray]:
        """Ends of every edge, the lower number first, (e, 2), and the edges of cells, (c, 3 or 4).

        Edges of a cell are in the order of `EDGES`.
        """
        ends = np.sort(self.corners[:, EDGES[self.cell]], axis=-1)
        key = ends[..., 0] * len(self.points) + ends[..., 1]
        unique, number = np.unique(key, return_inverse=True)
        return np.stack(np.divmod(unique, len(self.points)), axis=1), number.reshape(key.shape)


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


def split(plain: PlainMesh) -> PlainMesh:
    """Every cell divided into four of the same kind, and every line element of a curve into two.

    The map of the parent gives the new nodes, so that the shape does not change.
    """
    lattice, children = _lattice(plain.cell, plain.degree)
    key, n_key = _lattice_numbers(plain, lattice)
    values, _ = basis(plain.cell, plain.degree, lattice / (2.0 * plain.degree))
    places = values @ plain.points[plain.dolfinx_cells]  # (c, l, 2 or 3)
    points = np.empty((n_key, places.shape[-1]))
    points[key.ravel()] = places.reshape(-1, places.shape[-1])
    points, cells = used_nodes(points, key[:, children].reshape(-1, plain.cells.shape[1]))
    return replace(
        plain,
        points=points,
        cells=cells,
        region=np.repeat(plain.region, len(children)),
        curves={name: _halved(lines) for name, lines in plain.curves.items()},
        named=None,
    )


def _lattice(cell: str, degree: int) -> tuple[IntArray, IntArray]:
    """Nodes of all children of a cell, (l, 2), in steps of 1/(2 degree), and the nodes of each
    child, (4, k)."""
    n = 2 * degree
    grid = np.stack(np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"), axis=-1)
    lattice = grid.reshape(-1, 2)
    nodes = NODES[cell] if degree == 2 else NODES[cell][: len(EDGES[cell])] // 2
    shifts = np.array([[0, 0], [degree, 0], [degree, degree], [0, degree]])
    if cell == "triangle":
        lattice = lattice[lattice.sum(axis=1) <= n]
        parts = [nodes + shift for shift in shifts[[0, 1, 3]]] + [degree - nodes]
    else:
        parts = [nodes + shift for shift in shifts]
    row = {tuple(place): i for i, place in enumerate(lattice.tolist())}
    return lattice, np.array([[row[tuple(place)] for place in part.tolist()] for part in parts])


def _lattice_numbers(plain: PlainMesh, lattice: IntArray) -> tuple[IntArray, int]:
    """One number for each node of the children, (c, l), the same in cells that share it."""
    n = 2 * plain.degree
    ends, edges = plain.edges()
    corners = NODES[plain.cell][: len(EDGES[plain.cell])] * plain.degree
    key = np.full((len(plain.cells), len(lattice)), -1)
    first_inside = len(plain.points) + len(ends) * (n + 1)
    key[:] = first_inside + np.arange(key.size).reshape(key.shape)
    for local, (a, b) in enumerate(EDGES[plain.cell]):
        forward = plain.corners[:, a] == ends[edges[:, local], 0]
        for step in range(1, n):
            place = (corners[a] * (n - step) + corners[b] * step) // n
            column = int(np.flatnonzero((lattice == place).all(axis=1))[0])
            along = np.where(forward, step, n - step)
            key[:, column] = len(plain.points) + edges[:, local] * (n + 1) + along
    for local, place in enumerate(corners):
        column = int(np.flatnonzero((lattice == place).all(axis=1))[0])
        key[:, column] = plain.corners[:, local]
    return key, first_inside + key.size


def _halved(lines: Array) -> Array:
    """Line elements (s, 2 or 3, ...) divided at their middle."""
    a, b = lines[:, 0], lines[:, 1]
    middle = lines[:, 2] if lines.shape[1] == 3 else 0.5 * (a + b)
    if lines.shape[1] == 2:
        parts = np.stack([np.stack([a, middle], axis=1), np.stack([middle, b], axis=1)], axis=1)
    else:
        quarter = 0.375 * a + 0.75 * middle - 0.125 * b
        three_quarters = 0.375 * b + 0.75 * middle - 0.125 * a
        parts = np.stack(
            [
                np.stack([a, middle, quarter], axis=1),
                np.stack([middle, b, three_quarters], axis=1),
            ],
            axis=1,
        )
    return np.asarray(parts.reshape(-1, *lines.shape[1:]))
