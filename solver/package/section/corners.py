"""Re-entrant corners of a section, where stresses grow without limit as the mesh is refined."""

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array, IntArray
from .schema import CORNERS, SectionMeshData

MIDDLES = (22, 23, 28)  # VTK's cells with nodes in the middle of their sides, behind the corners
ANGLE_DEG = 195.0  # inside the material, above which a corner counts
WHOLE_DEG = 359.0  # above it a node lies inside the material


def reentrant_corners(mesh: SectionMeshData) -> tuple[IntArray, Array]:
    """Nodes (k,) on the boundary with more than 195 deg of material around them.

    Returns
    -------
    nodes, and the size of the largest cell at each, (k,) [m]
    """
    around, size = np.zeros(len(mesh.nodes)), np.zeros(len(mesh.nodes))
    for kind in np.unique(mesh.cell_types):
        rows = np.flatnonzero(mesh.cell_types == kind)
        first, last = mesh.offsets[rows[0]], mesh.offsets[rows[0] + 1]
        table = mesh.connectivity[mesh.offsets[rows][:, None] + np.arange(last - first)]
        n = CORNERS[int(kind)]
        corners = mesh.nodes[table[:, :n]]
        after, before = np.roll(corners, -1, axis=1), np.roll(corners, 1, axis=1)
        forth, back = after - corners, before - corners
        if int(kind) in MIDDLES:  # tangents of the parabolas
            middle = mesh.nodes[table[:, n : 2 * n]]
            forth = 4.0 * middle - 3.0 * corners - after
            back = 4.0 * np.roll(middle, 1, axis=1) - 3.0 * corners - before
        cross = forth[..., 0] * back[..., 1] - forth[..., 1] * back[..., 0]
        angle = np.abs(np.arctan2(cross, (forth * back).sum(axis=-1)))
        np.add.at(around, table[:, :n], angle)
        reach = np.linalg.norm(after - corners, axis=-1).max(axis=1)
        np.maximum.at(size, table[:, :n], reach[:, None])
    found = np.flatnonzero((around > np.radians(ANGLE_DEG)) & (around < np.radians(WHOLE_DEG)))
    return found, size[found]


def near_corner(mesh: SectionMeshData, points: Array, distance: float) -> NDArray[np.bool_]:
    """True for points (p, 2) nearer than `distance` [m] to a re-entrant corner, (p,)."""
    corners, _ = reentrant_corners(mesh)
    near = np.zeros(len(points), dtype=bool)
    for place in mesh.nodes[corners]:
        near |= np.linalg.norm(points - place, axis=1) < distance
    return near
