"""Factor of the ratio of shear to bending on the sides of quadrilaterals.

On a long side of a narrow strip, of length L and with cells of width H, the shear strain of
torsion belongs to the width: a strip one cell wide is too stiff in torsion with the ratio of its
length alone. With

    phi_k (1 + L_k^2/H_k^2)

the torsional stiffness of such a strip is that of bilinear rotations, and of a square cell nearly
unchanged. Both neighbours of a side need one number, or constant curvature is not exact: H is the
mean of area/L over the cells of the side. A side shared with a triangle has no factor, as the
triangle has none.
"""

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.shell.cells import NONE, area_vectors, corner_counts, sides


def side_factors(points_G: Array, cells: IntArray) -> Array:
    """1 + L^2/H^2 of each side of each cell, (c, 4) or (c, 3); 1 for sides of triangles."""
    factors = np.ones(cells.shape)
    if cells.shape[1] == 3:
        return factors
    ends, owner = sides(cells)
    length = np.linalg.norm(points_G[ends[:, 1]] - points_G[ends[:, 0]], axis=1)
    width = np.linalg.norm(area_vectors(points_G, cells), axis=1)[owner] / length
    key = np.sort(ends, axis=1) @ [len(points_G), 1]
    _, number = np.unique(key, return_inverse=True)
    number = number.ravel()
    count = np.bincount(number)
    mean = np.bincount(number, weights=width) / count
    triangle = corner_counts(cells)[owner] == 3
    beside = np.bincount(number, weights=triangle) > 0
    factor = np.where(beside[number], 1.0, 1.0 + (length / mean[number]) ** 2)
    factors[cells != NONE] = factor
    return factors
