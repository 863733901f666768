"""A mesh of half the cell size on the curved surface, and functions of the coarse mesh on it.

A curved surface is known from its nodes only. A quadratic function fitted to the nodes around a
cell gives the distance of its side's middle from the chord. Neighbours whose normals differ by more
than `FOLD` belong to another surface; the curve in which two surfaces meet lies on both.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import NONE, corner_counts
from ...fenicsx import NamedNodes, PlainMesh
from .mesh import ShellMesh, mesh_of
from .refinement import split

FOLD = 0.75  # least cosine between normals of one smooth surface: 41 deg
FLAT = 1e-8  # of the largest eigenvalue: a direction in which the nodes around a cell do not extend
ONE_SURFACE = 0.1  # the same for the normals of the cells at a side: below, they are of one surface


class Refined(NamedTuple):
    """A finer mesh, and the values at its nodes of functions that are linear along sides."""

    mesh: ShellMesh
    from_coarse: sp.csr_matrix  # (n_fine, n)


def refined(mesh: ShellMesh) -> Refined:
    """The mesh with twice as many cells along every side; the old nodes come first."""
    n, cells = mesh.n_node, mesh.cells
    kind = "triangle" if cells.shape[1] == 3 else "mixed"
    named = NamedNodes(np.arange(1, n + 1), mesh.curves, mesh.marks)
    straight = split(PlainMesh(mesh.points_G, cells, kind, 1, mesh.region, mesh.regions, {}, named))
    heights = _heights(mesh)
    # four sides that meet at a centre: half the sum of their middles less a quarter of the corners
    four = np.flatnonzero(corner_counts(cells) == 4)
    of_cell = np.zeros((len(cells), 3))
    np.add.at(of_cell, mesh.edges.owner, 0.5 * heights[mesh.edges.number])
    above = np.concatenate([np.zeros((n, 3)), heights, of_cell[four]])
    fine = mesh_of(replace(straight, points=straight.points + above), "finer mesh")
    return Refined(fine, _interpolation(n, mesh.edges.nodes, cells[four]))


def _interpolation(n: int, pairs: IntArray, four: IntArray) -> sp.csr_matrix:
    """Means of the ends of sides and of the corners of quadrilaterals, (n_fine, n)."""
    blocks = [sp.identity(n, format="csr")]
    for nodes in (pairs, four):
        m, k = nodes.shape
        entries = (np.full(m * k, 1.0 / k), (np.repeat(np.arange(m), k), nodes.ravel()))
        blocks.append(sp.csr_matrix(entries, shape=(m, n)))
    return sp.csr_matrix(sp.vstack(blocks))


def _heights(mesh: ShellMesh) -> Array:
    """From the chord to the surface in the middle of each edge, (e, 3) [m]."""
    edges, owner = mesh.edges, mesh.edges.owner
    axes, curvature = _curvatures(mesh)
    along = np.einsum("sij,sj->si", axes[owner], np.diff(mesh.points_G[edges.ends], axis=1)[:, 0])[
        :, :2
    ]
    height = -0.125 * np.einsum("si,sij,sj->s", along, curvature[owner], along)
    normal = axes[owner, 2]
    A, b = edges.sums(normal[:, :, None] * normal[:, None]), edges.sums(height[:, None] * normal)
    inverse = np.linalg.pinv(A, rcond=ONE_SURFACE, hermitian=True)
    return np.asarray(np.einsum("sij,sj->si", inverse, b))


def _curvatures(mesh: ShellMesh) -> tuple[Array, Array]:
    """Axes (c, 3, 3) of each cell as rows; second derivatives (c, 2, 2) of its surface [1/m]."""
    areas = mesh.area_vectors_G
    normal = areas / np.linalg.norm(areas, axis=1, keepdims=True)
    e1 = mesh.points_G[mesh.cells[:, 1]] - mesh.points_G[mesh.cells[:, 0]]
    e1 -= normal * (e1 * normal).sum(axis=1, keepdims=True)
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    axes = np.stack([e1, np.cross(normal, e1), normal], axis=1)
    cell, node = _around(mesh, normal)
    size = np.sqrt(np.linalg.norm(areas, axis=1))
    away = (mesh.points_G[node] - mesh.centres_G[cell]) / size[cell, None]
    x, y, z = np.einsum("kij,kj->ik", axes[cell], away)
    terms = np.stack([np.ones_like(x), x, y, 0.5 * x * x, x * y, 0.5 * y * y], axis=1)
    A, b = np.zeros((len(areas), 6, 6)), np.zeros((len(areas), 6))
    np.add.at(A, cell, terms[:, :, None] * terms[:, None, :])
    np.add.at(b, cell, terms * z[:, None])
    fitted = np.einsum("cij,cj->ci", np.linalg.pinv(A, rcond=FLAT, hermitian=True), b)
    second = fitted[:, [3, 4, 4, 5]].reshape(-1, 2, 2)
    return axes, second / size[:, None, None]


def _around(mesh: ShellMesh, normal: Array) -> tuple[IntArray, IntArray]:
    """Pairs of a cell and a node of it or of a neighbour of the same surface, each once."""
    c = len(mesh.cells)
    row, column = np.nonzero(mesh.cells != NONE)
    corner = mesh.cells[row, column]
    at = sp.csr_matrix((np.ones(len(row)), (row, corner)), shape=(c, mesh.n_node))
    near = sp.coo_matrix(at @ at.T)
    smooth = np.abs((normal[near.row] * normal[near.col]).sum(axis=1)) > FOLD
    entries = (np.ones(smooth.sum()), (near.row[smooth], near.col[smooth]))
    found = sp.coo_matrix(sp.csr_matrix(entries, shape=(c, c)) @ at)
    return found.row, found.col
