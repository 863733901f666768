"""Tetrahedra of 10 and hexahedra of 27 nodes in gmsh's order: faces, derivatives, VTK."""

from functools import lru_cache
from itertools import product

import numpy as np

from ...solver.math.arrays import Array, IntArray

# Nodes in halves of the reference cell, as gmsh orders them: corners, edges, faces, centre.
_EDGES = {
    "tetrahedron": ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)),
    "hexahedron": (
        *((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3)),
        *((2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)),
    ),
}
_FACES = {  # corners, counter-clockwise seen from outside, in gmsh's order of the middle nodes
    "tetrahedron": ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)),
    "hexahedron": (
        *((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3)),
        *((1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)),
    ),
}
_CORNERS = {
    "tetrahedron": np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "hexahedron": np.array(
        [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    ),
}
CORNERS = {cell: len(corners) for cell, corners in _CORNERS.items()}
# VTK's quadratic tetrahedron, and its hexahedron of 20 nodes, from gmsh's order.
VTK = {
    "tetrahedron": (24, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    "hexahedron": (25, [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]),
}


@lru_cache
def reference_nodes(cell: str) -> Array:
    """Nodes of the reference cell, (k, 3)."""
    corners = _CORNERS[cell].astype(float)
    found = [corners, *(corners[list(e)].mean(axis=0)[None] for e in _EDGES[cell])]
    if cell == "hexahedron":
        found += [corners[list(f)].mean(axis=0)[None] for f in _FACES[cell]]
        found.append(corners.mean(axis=0)[None])
    return np.concatenate(found)


def linear_weights(cell: str) -> Array:
    """Value of the linear function of each corner at each node, (k, corners)."""
    x, corners = reference_nodes(cell), _CORNERS[cell]
    if cell == "tetrahedron":
        return np.column_stack([1.0 - x.sum(axis=1), x])
    sides = np.where(corners[None] > 0, x[:, None], 1.0 - x[:, None])
    return np.asarray(sides.prod(axis=2))


@lru_cache
def faces(cell: str) -> IntArray:
    """Local nodes of each face: corners, then the middles of its edges, (f, 6 or 8)."""
    number = {frozenset(e): len(_CORNERS[cell]) + i for i, e in enumerate(_EDGES[cell])}
    rows = []
    for face in _FACES[cell]:
        pairs = zip(face, (*face[1:], face[0]), strict=True)
        rows.append([*face, *(number[frozenset(pair)] for pair in pairs)])
    return np.array(rows)


def boundary(cells: IntArray, cell: str) -> tuple[IntArray, IntArray, IntArray]:
    """Faces of one cell only: their nodes (f, 6 or 8), cell (f,) and number in it (f,)."""
    local = faces(cell)
    nodes = cells[:, local].reshape(-1, local.shape[1])
    corners = np.sort(nodes[:, : local.shape[1] // 2], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    own = np.sort(first[count == 1])
    return nodes[own], own // len(local), own % len(local)


def derivatives(cell: str, at: Array) -> Array:
    """Derivatives of the functions of the nodes at a place of the reference cell, (3, k)."""
    if cell == "tetrahedron":
        powers = [p for p in product(range(3), repeat=3) if sum(p) <= 2]
    else:
        powers = list(product(range(3), repeat=3))
    exponents = np.array(powers)
    known = np.prod(reference_nodes(cell)[:, None, :] ** exponents, axis=2)
    rows = []
    for axis in range(3):
        lower = exponents.copy()
        lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
        rows.append(exponents[:, axis] * np.prod(at**lower, axis=1))
    return np.asarray(np.linalg.solve(known.T, np.array(rows).T).T)


def face_centre(cell: str, face: int) -> Array:
    """Centre of a face in the reference cell, (3,)."""
    return np.asarray(_CORNERS[cell][list(_FACES[cell][face])].mean(axis=0))
