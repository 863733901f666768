"""Matrices of a section by NumPy alone, from the gradient of the displacement.

The judge of strains.py and of what DOLFINx evaluates: other functions, another map, another text.
Of the engine it takes the mesh, the numbering of the unknowns, and the rule of integration.
"""

from typing import Any

import numpy as np
import scipy.sparse as sp

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.cells import KINDS
from plymotion.preprocess.section.space import SectionSpace

ROWS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def functions(cell: str, nodes: Any, degree: int, place: Any) -> Any:
    """Values and two slopes at a place, (3, k), of the polynomials that are 1 at one node each."""

    def monomials(x: float, y: float) -> Any:
        powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1)]
        kept = [(i, j) for i, j in powers if cell == "quadrilateral" or i + j <= degree]
        values = [x**i * y**j for i, j in kept]
        by_x = [i * x ** max(i - 1, 0) * y**j for i, j in kept]
        by_y = [j * x**i * y ** max(j - 1, 0) for i, j in kept]
        return np.array([values, by_x, by_y])

    at_nodes = np.array([monomials(*node)[0] for node in nodes])
    return np.linalg.solve(at_nodes.T, monomials(*place).T).T


def matrices(space: SectionSpace, C: Any, k: Any = (0.0, 0.0, 0.0)) -> list[sp.csr_matrix]:
    """E, H, L of a space of one kind of cells for C (c, 6, 6), with G_k, G_l / g and g dA."""
    ((kind, _),), (shapes,) = space.mesh.of_kinds, space.mesh.shapes
    cell = KINDS[kind]
    nodes = fenicsx.reference_nodes(cell, space.degree)
    c, n = space.dofs.shape
    found = np.zeros((3, c, 3 * n, 3 * n))
    for place, weight in zip(*fenicsx.quadrature(cell, space.quadrature_degree), strict=True):
        map_ = functions(cell, fenicsx.NODES[cell] / 2.0, 2, place)
        x, jacobian = (map_ @ shapes)[:, 0], (map_ @ shapes)[:, 1:]
        u, *slopes = functions(cell, nodes, space.degree, place)
        by_x = np.linalg.solve(jacobian, np.broadcast_to(slopes, (c, 2, n)))
        x2, x3 = x.T[..., None]
        g = 1.0 - k[2] * x2 + k[1] * x3
        F = np.zeros((2, c, n, 3, 3, 3))  # of w and w': [cell, function, a, i, j] = d u_i / d x_j
        for a, e in enumerate(np.eye(3)):
            F[0, :, :, a, a, 1:] = by_x.swapaxes(1, 2)
            turned = k[0] * (x3 * by_x[:, 0] - x2 * by_x[:, 1])[..., None] * e
            F[0, :, :, a, :, 0] = (u[:, None] * np.cross(k, e) + turned) / g[..., None]
            F[1, :, :, a, a, 0] = u / g
        double = (F + F.swapaxes(-1, -2)).reshape(2, c, 3 * n, 3, 3)
        G, L = np.stack([double[..., i, j] / (2 if i == j else 1) for i, j in ROWS], axis=2)
        dA = (g[:, 0] * weight * np.abs(np.linalg.det(jacobian)))[:, None, None]
        for matrix, left, right in zip(found, (G, G, L), (G, L, L), strict=True):
            matrix += dA * left.swapaxes(1, 2) @ (C @ right)
    unknowns = (3 * space.dofs[:, :, None] + np.arange(3)).reshape(c, -1)
    rows, columns = np.repeat(unknowns, 3 * n, axis=1).ravel(), np.tile(unknowns, 3 * n).ravel()
    size = (space.n_dof, space.n_dof)
    return [sp.csr_matrix((matrix.ravel(), (rows, columns)), shape=size) for matrix in found]
