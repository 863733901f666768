"""Loads that would deform bodies which do not deform: those of a mechanism held as it is."""

import numpy as np

from ..math.arrays import Array
from .model import Model
from .series import along_solution

_HEAVY = 1e8  # modal mass over that of the model: bodies then move as if rigid


def held_deformations(model: Model, t: float, y: Array) -> list[Array]:
    """Return, for each body, the change of its modal coordinates (m,) that its loads call for.

    The mechanism moves from state y (n,) with the shapes that its bodies have there. The loads
    on the modes are those of this motion: weight, forces, inertia, and reactions of the joints.
    The change is K^-1 times these loads; of a body in static equilibrium it is zero.
    """
    heavy = model._replace(M_qq=_HEAVY * model.M_qq, alpha=0.0, beta=0.0, penalty=0.0)
    rates, _ = along_solution(heavy, np.array([t]), y[None, :])
    found: list[Array] = []
    for i in range(model.n_body):
        m, square = int(model.n_mode[i]), int(model.square_start[i])
        j = model.n_pos + int(model.vel_start[i]) + 6
        block = slice(square, square + m * m)
        loads = heavy.M_qq[block].reshape(m, m) @ rates[0, j : j + m]
        found.append(np.asarray(np.linalg.solve(model.K_qq[block].reshape(m, m), loads)))
    return found


def is_moving(model: Model, y: Array, *, at_most: float = 1e-9) -> bool:
    """Tell whether a body moves in state y (n,): speed above `at_most` [m/s, rad/s, 1/s]."""
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    return bool(np.max(np.abs(velocities), initial=0.0) > at_most)
