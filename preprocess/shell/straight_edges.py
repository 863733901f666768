"""Edges that a support keeps straight in the plane of the shell.

The sides of cells bow with the difference of their rotations about the normal. A support that holds
the displacement normal to a free edge, in the plane of the shell, at every node would leave this
bow: a plate with four cells along such an edge, stretched by it, would be 12 % too soft. Where the
edge can slide along itself there is no shear, as at a plane of symmetry: the rotation is zero.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from ...solver.package.shell.cells import sides
from .assembly import DOFS
from .mesh import ShellMesh
from .supports import ONLY, Support

BoolArray = NDArray[np.bool_]

ALIGNED = 1e-6  # component of a unit vector that is treated as none
FLAT = np.cos(np.radians(1.0))  # of the angle between normals of cells that are treated as one


def with_straight_edges(supports: Sequence[Support], mesh: ShellMesh) -> list[Support]:
    """The supports, with rotations about the normal at nodes of edges that they keep straight.

    For flat parts with a normal along x, y or z: other rotations are not degrees of freedom.
    """
    ends, normal = _free_edges(mesh)
    axis = np.abs(normal).argmax(axis=1)
    aligned = np.abs(normal).max(axis=1) > 1.0 - ALIGNED
    ends, normal, axis = ends[aligned], normal[aligned], axis[aligned]
    if len(ends) == 0:
        return list(supports)
    along = mesh.points_G[ends[:, 1]] - mesh.points_G[ends[:, 0]]
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.cross(along, normal)
    out = []
    for support in supports:
        own = _held([support], mesh)
        purposes = ONLY if support.only is None else (support.only,)
        slides = np.zeros(len(ends), dtype=bool)
        for purpose in purposes:
            held = _held([s for s in supports if s.only in (None, purpose)], mesh)
            slides |= ~_holds(held[ends], along).all(axis=1)
        straight = _holds(own[ends], across).all(axis=1) & slides
        more = DOFS * ends[straight] + 3 + axis[straight][:, None]
        out.append(support._replace(dofs=np.union1d(support.dofs, more.ravel())))
    return out


def _holds(held: BoolArray, direction: Array) -> BoolArray:
    """Whether nodes with held components (s, 2, 3) cannot move along (s, 3): (s, 2) bool."""
    return np.asarray((held | (np.abs(direction) < ALIGNED)[:, None]).all(axis=2))


def _held(supports: Sequence[Support], mesh: ShellMesh) -> BoolArray:
    """(n, 3) bool: displacements that supports hold."""
    held = np.zeros((mesh.n_node, DOFS), dtype=bool)
    for support in supports:
        dofs = support.dofs[support.dofs < held.size]
        held.ravel()[dofs] = True
    return held[:, :3]


def _free_edges(mesh: ShellMesh) -> tuple[IntArray, Array]:
    """Sides of one cell only, (s, 2), and its normal, (s, 3), where the shell is flat at both."""
    pairs, cell = sides(mesh.cells)
    keys = np.sort(pairs, axis=1)
    _, first, count = np.unique(keys, axis=0, return_index=True, return_counts=True)
    single = first[count == 1]
    normals = mesh.area_vectors_G
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    total = np.zeros((mesh.n_node, 3))
    number = np.zeros(mesh.n_node)
    for corner in mesh.cells.T:
        there = corner >= 0
        np.add.at(total, corner[there], normals[there])
        np.add.at(number, corner[there], 1.0)
    # the length of a mean of unit vectors: 1 only where all are equal
    flat = np.linalg.norm(total, axis=1) > FLAT * number
    single = single[flat[pairs[single]].all(axis=1)]
    return pairs[single], normals[cell[single]]
