"""Values at integration points as shades of the cells."""

import numpy as np
from matplotlib.tri import Triangulation

from ....math.arrays import Array
from ....package.section.schema import SectionFile
from ....package.section.stress import cell_means
from .drawing import Shape


class CellField:
    """Values at the integration points as a polynomial in every cell, and its cells as triangles.

    The polynomial has degree 2, or 1 in a cell with more than one ply.
    """

    def __init__(self, section: SectionFile, shape: Shape) -> None:
        self.section, self.shape = section, shape
        recovery = section.recovery
        self.area = np.bincount(recovery.cell, weights=recovery.weights)
        self.middle = cell_means(section, shape.scale * recovery.points)
        arm = shape.scale * recovery.points - self.middle[recovery.cell]
        self.reach = np.sqrt(cell_means(section, (arm**2).sum(axis=1)))
        self.basis = _monomials(arm / self.reach[recovery.cell, None])
        gram = cell_means(section, np.einsum("pi,pj->pij", self.basis, self.basis))
        other = recovery.ply != section.mesh.ply[recovery.cell]
        several = cell_means(section, other.astype(float)) > 0.0
        gram[several, 3:] = gram[several, :, 3:] = 0.0
        self.solve = np.linalg.pinv(gram, hermitian=True)
        # a fan of triangles about the middle of each cell; cells have no common points
        points, triangles, cells = [], [], []
        start = 0
        for cell, polygon in enumerate(shape.polygons):
            n = len(polygon)
            ring = start + 1 + np.arange(n)
            points += [polygon.mean(axis=0)[None], polygon]
            triangles.append(np.column_stack([np.full(n, start), ring, np.roll(ring, -1)]))
            cells += [cell] * (n + 1)
            start += n + 1
        self.corners_at, self.cells = np.concatenate(points), np.array(cells)
        x2, x3 = self.corners_at.T
        self.triangles = Triangulation(x2, x3, np.concatenate(triangles))
        self.corners = _monomials(
            (self.corners_at - self.middle[self.cells]) / self.reach[self.cells, None]
        )

    def at_corners(self, values: Array) -> Array:
        """Values of the least-squares polynomials at the corners of the triangles."""
        load = cell_means(self.section, values[:, None] * self.basis)
        factors = np.einsum("cij,cj->ci", self.solve, load)
        return np.einsum("ni,ni->n", factors[self.cells], self.corners)


def _monomials(x: Array) -> Array:
    a, b = x.T
    return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)
