"""Absolute tolerances of the state from the keys of `[solver]`."""

from typing import Protocol

import numpy as np

from ..dynamics.model import Model
from ..math.arrays import Array


class ToleranceKeys(Protocol):
    """The keys of `[solver]` that set the tolerances of a step."""

    @property
    def rtol(self) -> float:
        """Relative tolerance."""

    @property
    def atol_position(self) -> float:
        """Absolute tolerance of positions and modal coordinates."""

    @property
    def atol_velocity(self) -> float:
        """Absolute tolerance of velocities and modal rates."""


def tolerances(model: Model, solver: ToleranceKeys) -> Array:
    """Return absolute tolerances (n,) of positions, velocities and the work."""
    atol = np.full(model.n_pos + model.n_vel + 1, float(solver.atol_velocity))
    atol[: model.n_pos] = solver.atol_position
    return atol
