"""A free body as another code describes it: nodes, cells, stiffness and mass."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import rigid_motions
from .layups import Cells, Layups

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class FreeBody:
    """Matrices of a body that nothing holds; n nodes, N degrees of freedom.

    Attributes
    ----------
    where : file or object that messages name
    nodes : (n, 3) [length]
    node_ids : (n,) labels, unique
    cells : of the mesh
    K, M : (N, N) sparse, both triangles
    dof_node : (N,) row of the node
    dof_direction : (N,) 0 to 2 translation, 3 to 5 rotation, along and about the global axes
    groups : rows of nodes by name of a set in the source
    notes : facts about the source, for the provenance
    layups : laminates of cells, for ply stresses
    """

    where: str
    nodes: Array
    node_ids: IntArray
    cells: Cells
    K: sp.csr_matrix
    M: sp.csr_matrix
    dof_node: IntArray
    dof_direction: IntArray
    groups: dict[str, IntArray] = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)
    layups: Layups | None = None

    def rigid_motions(self) -> Array:
        """Rigid motions in the dofs, (N, 6): along and about the axes through the origin."""
        return np.asarray(rigid_motions(self.nodes)[self.dof_node, self.dof_direction])

    def in_units(self, length: float, mass: float, time: float) -> "FreeBody":
        """The same body in SI; arguments: the size of the source's units in m, kg and s.

        A translation is a length and a rotation is a number, so each row and column of a rotation
        has one more power of the length.
        """
        if length == mass == time == 1.0:
            return self  # no copies of large matrices
        arm = sp.diags(np.where(self.dof_direction < 3, 1.0, length))
        K, M = (sp.csr_matrix(arm @ A @ arm) for A in (self.K, self.M))
        layups = self.layups and self.layups.in_units(length, mass, time)
        nodes = self.nodes * length
        return replace(self, nodes=nodes, K=K * (mass / time**2), M=M * mass, layups=layups)

    def labels(self, dof: int) -> str:
        """Node and direction of a dof, for messages."""
        label = self.node_ids[self.dof_node[dof]]
        return f"node {label}, direction {DIRECTIONS[self.dof_direction[dof]]}"
