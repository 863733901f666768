"""Matrices and rows of single cells, from the same pairs that DOLFINx assembles.

Corners run around the cell here, as everywhere but in DOLFINx.
"""

import numpy as np

from ....solver.math.arrays import Array
from ... import fenicsx
from ..mesh.quadrilaterals import Quadrilaterals
from ..mesh.triangles import Triangles
from .cell import AROUND


def cell_matrices(t: Triangles | Quadrilaterals, kernel: fenicsx.Kernel, table: Array) -> Array:
    """Matrices of cells in G, (c, 6 k, 6 k), with data (c, columns) of table.py."""
    order = _unknowns(t)
    return fenicsx.matrices(kernel, table, _corners(t))[:, order[:, None], order]


def cell_rows(
    t: Triangles | Quadrilaterals, kernel: fenicsx.Kernel, table: Array
) -> list[tuple[Array, Array, Array]]:
    """Stresses (c, p, 6 k), strains (c, p, 6 k) of the pairs and mean strains (c, n, 6 k) of each
    list of a kernel, per unit of the unknowns in G."""
    found = []
    for number, given in enumerate(kernel.lists):
        rows = fenicsx.rows(kernel, number, table, _corners(t))[:, :, _unknowns(t)]
        p = given.pairs
        found.append((rows[:, :p], rows[:, p : 2 * p], rows[:, 2 * p + given.coupling :]))
    return found


def _corners(t: Triangles | Quadrilaterals) -> Array:
    """(c, k, 3) in DOLFINx's order; from the centroid, for strains do not depend on the place."""
    return np.ascontiguousarray(t.corners_G[:, AROUND[t.xy_E.shape[1]]])


def _unknowns(t: Triangles | Quadrilaterals) -> Array:
    """Unknown of DOLFINx's cell for each one around the cell; the order is its own inverse."""
    around = np.array(AROUND[t.xy_E.shape[1]])
    return np.asarray((6 * around[:, None] + np.arange(6)).ravel())
