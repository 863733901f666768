"""Nodes with five degrees of freedom: a flat surface has no stiffness about its normal.

Membranes without drilling rotations have no stiffness about the normal if all triangles of
a node lie in one plane. This rotation is then not an unknown: n . theta = 0. Nodes on a fold keep
six, because bending of one side is drilling of the other. Paper: Eq. (23).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...solver.math.arrays import Array, IntArray
from .mesh import ShellMesh
from .regions import Region
from .stiffeners import Stiffener

FLAT = np.sin(np.radians(1.0)) ** 2  # relative second moment of the normals about their mean


class FlatNodes(NamedTuple):
    """Nodes (k,) with the normals (k, 3) about which they do not rotate."""

    nodes: IntArray
    normals_G: Array


def flat_nodes(
    mesh: ShellMesh, regions: Sequence[Region], stiffeners: Sequence[Stiffener] = ()
) -> FlatNodes:
    """Nodes with all cells in one plane to within one degree, without a stiffener."""
    table = np.zeros((mesh.n_node, 3, 3))
    for region in regions:
        n = region.geometry.A_GE[:, :, 2]
        np.add.at(table, region.nodes, (n[:, :, None] * n[:, None, :])[:, None])
    value, axis = np.linalg.eigh(table)
    flat = value[:, 1] < FLAT * value[:, 2]
    for stiffener in stiffeners:
        flat[stiffener.ends] = False
    return FlatNodes(np.flatnonzero(flat), axis[flat, :, 2])


def dependent_rotations(flat: FlatNodes, fixed: Array) -> tuple[IntArray, IntArray, Array]:
    """Dependence of one rotation of each flat node on its other two.

    Parameters
    ----------
    fixed : (n_dof,) bool, fixed degrees of freedom

    Returns
    -------
    (k,) dependent degrees of freedom, (k, 2) the degrees of freedom that determine them, (k, 2)
    factors. Nodes with supports that prevent the rotation are omitted.
    """
    rotations = 6 * flat.nodes[:, None] + np.arange(3, 6)  # (k, 3)
    share = np.where(fixed[rotations], 0.0, np.abs(flat.normals_G))
    last = np.argmax(share, axis=1)
    row = np.arange(len(last))
    some = share[row, last] > 0.1
    row, last = row[some], last[some]
    others = (last[:, None] + np.array([1, 2])) % 3
    n = flat.normals_G[row]
    pick = np.arange(len(row))
    factors = -np.take_along_axis(n, others, axis=1) / n[pick, last][:, None]
    return rotations[row, last], np.take_along_axis(rotations[row], others, axis=1), factors
