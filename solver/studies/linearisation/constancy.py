"""Whether linearised equations stay the same while the mechanism turns."""

import numpy as np
from scipy.linalg import block_diag

from ...dynamics.model.model import Model
from ...math.arrays import Array
from .modes import Modes
from .state_space import StateSpace


def change_when_turned(
    model: Model, space: StateSpace, modes: Modes, later: StateSpace, A: Array
) -> float:
    """Return how much the equations change when the mechanism has turned by A (3, 3).

    Largest element of the change of the system matrix between two modes, over the larger of their
    eigenvalues. The eigenvalues alone do not tell: on supports that differ in two directions, those
    of an axisymmetric rotor are the same at any angle, though its equations are not.
    """
    moving = ~modes.still
    if not moving.any():
        return 0.0
    turn = np.eye(model.n_vel)
    for j in model.vel_start:
        turn[j : j + 3, j : j + 3] = A
    both = block_diag(turn, turn, np.eye(space.auxiliary.size))
    into = _left(space) @ both.T @ _right(later)
    back = _left(later) @ both @ _right(space)
    change = into @ later.A_free @ back - space.A_free
    values = np.abs(modes.eigenvalues[moving])
    left, right = modes.left[:, moving], modes.right[:, moving]
    found = np.maximum(np.abs(left.conj().T @ change @ right), np.abs(left.T @ change @ right))
    return float((found / np.maximum.outer(values, values)).max())


def _right(space: StateSpace) -> Array:
    Z = space.free.Z
    moving = np.block([[Z, np.zeros_like(Z)], [space.velocity, Z]])
    return np.asarray(block_diag(moving, np.eye(space.auxiliary.size)), dtype=float)


def _left(space: StateSpace) -> Array:
    left, others = space.free.Z_left, np.eye(space.auxiliary.size)
    return np.asarray(block_diag(left, left, others), dtype=float)
