"""Input of a beam to the mode computation: reference condition and static loads."""

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import rigid_motions
from ...solver.package.body.specification import DIRECTIONS
from ..modes import Condition, HeldDofs, MeanAxis, StaticLoad, inertia_loads
from .line import BeamLine
from .spec_modes import ModeSpec

# Dofs of the reference nodes that are fixed in the frame. Clamped: all six of a node. Chord:
# the x axis runs through both nodes, and there is no twist at the first.
CLAMPED = (range(6),)
CHORD = ((0, 1, 2, 3), (1, 2))


def reference_condition(
    line: BeamLine, mass_form: str, kind: str, nodes: tuple[int, ...]
) -> Condition:
    """Reference condition of a beam.

    Parameters
    ----------
    line : the beam
    mass_form : "consistent" or "lumped": of the eigenproblem and of the mean axis
    kind : one of REFERENCE_CONDITIONS
    nodes : nodes that carry the frame: one if clamped, two for a chord, none for a mean axis

    Raises
    ------
    ModeError : a mean axis of a body without inertia about some axis.
    """
    K, M = line.stiffness(), line.mass_matrix(mass_form)
    held = held_dofs(kind, nodes)
    if held is None:
        return MeanAxis(K, M, rigid_motions(line.nodes_B).reshape(6 * line.n_node, 6))
    return HeldDofs(K, M, held)


def held_dofs(kind: str, nodes: tuple[int, ...]) -> IntArray | None:
    """Dofs (6,) that are fixed in the frame of `reference_condition`; None for a mean axis."""
    if kind == "mean-axis":
        return None
    dofs = CLAMPED if kind == "clamped" else CHORD
    return np.array([6 * n + dof for n, own in zip(nodes, dofs, strict=True) for dof in own])


def static_loads(
    line: BeamLine, spec: ModeSpec, node_of: dict[str, int], origin: int
) -> list[StaticLoad]:
    """Loads of the static modes that a specification requests.

    `node_of` has the nodes of the interfaces. `origin` is the node where the load that increases
    along the beam is zero (for a mean axis it is zero at the mass centre in any case).
    """
    zero = np.zeros(6 * line.n_node)
    loads = []
    for at, direction in spec.attachments:
        force = zero.copy()
        force[6 * node_of[at] + DIRECTIONS.index(direction)] = 1.0
        loads.append(StaticLoad(f"attachment {at} {direction}", force, zero))
    if spec.static_axial:
        loads.append(StaticLoad("static-axial", zero, _centrifugal(line, origin)))
    if spec.static_inertia:
        loads += inertia_loads(rigid_motions(line.nodes_B).reshape(6 * line.n_node, 6))
    return loads


def _centrifugal(line: BeamLine, origin: int) -> Array:
    """Centrifugal acceleration x - x_origin along x at 1 rad/s, (6 n,)."""
    acceleration = np.zeros((line.n_node, 6))
    acceleration[:, 0] = line.nodes_B[:, 0] - line.nodes_B[origin, 0]
    return acceleration.ravel()
