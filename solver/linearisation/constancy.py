"""Whether linearised equations stay the same while the mechanism turns."""

import numpy as np

from ..dynamics.model import Model
from ..math.arrays import Array
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
    both = np.kron(np.eye(2), turn)
    into = _left(space) @ both.T @ _right(later)
    back = _left(later) @ both @ _right(space)
    change = into @ later.A_free @ back - space.A_free
    values = np.abs(modes.eigenvalues[moving])
    left, right = modes.left[:, moving], modes.right[:, moving]
    found = np.maximum(np.abs(left.conj().T @ change @ right), np.abs(left.T @ change @ right))
    return float((found / np.maximum.outer(values, values)).max())


def _right(space: StateSpace) -> Array:
    Z = space.free.Z
    return np.asarray(np.block([[Z, np.zeros_like(Z)], [space.velocity, Z]]), dtype=float)


def _left(space: StateSpace) -> Array:
    return np.asarray(np.kron(np.eye(2), space.free.Z_left), dtype=float)
