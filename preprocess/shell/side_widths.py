"""How long the sides of quadrilaterals are compared with the width of their cells.

On a long side of a narrow strip, of length L and with cells of width H, the shear strain of
torsion belongs to the width: a strip one cell wide is too stiff in torsion with the ratio of shear
to bending of its length alone, phi_L. With phi_H = phi_L L^2/H^2, that of the width, and

    phi = phi_L + phi_H + phi_H^2                                                  (ours)

the torsional stiffness of a thin strip is that of bilinear rotations, and of a thick one that of
cubic rotations (quads/internal.py). A square cell that is thin is nearly unchanged. The square was
chosen by the torsion of strips. Both neighbours of a side need one number, or constant curvature
is not exact: H is the mean of area/L over the cells of the side. A side shared with a triangle has
phi_L alone, as the triangle has.
"""

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.shell.cells import NONE, area_vectors, corner_counts, sides


def width_ratios(points_G: Array, cells: IntArray) -> Array:
    """L^2/H^2 of each side of each cell, (c, 4) or (c, 3); 0 for sides of triangles."""
    ratios = np.zeros(cells.shape)
    if cells.shape[1] == 3:
        return ratios
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
    ratios[cells != NONE] = np.where(beside[number], 0.0, (length / mean[number]) ** 2)
    return ratios
