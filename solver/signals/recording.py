"""Data of a run for sensors: states at the output times, and quantities computed on demand."""

from functools import cached_property

import numpy as np

from ..dynamics.bodies.marker import Marker, marker_motion
from ..dynamics.model import Model
from ..dynamics.reactions import joint_reactions
from ..dynamics.system import accelerations, assemble
from ..math.arrays import Array


class Recording:
    """States y (k, n) of a model at times t (k,); each quantity is computed once."""

    def __init__(self, model: Model, t: Array, y: Array) -> None:
        self.model, self.t, self.y = model, t, y
        self._motions: dict[int, list[Marker]] = {}

    def motions(self, marker: int) -> list[Marker]:
        """Motion of a marker in every state."""
        if marker not in self._motions:
            self._motions[marker] = [marker_motion(self.model, marker, y) for y in self.y]
        return self._motions[marker]

    def modes(self, body: int) -> Array:
        """Modal coordinates (k, m) of a body."""
        a = int(self.model.pos_start[body]) + 7
        return self.y[:, a : a + int(self.model.n_mode[body])]

    def acceleration(self, marker: int) -> Array:
        """Acceleration (k, 3) of a marker's origin, global [m/s2]."""
        body = int(self.model.marker_body[marker])
        if body < 0:
            return np.zeros((len(self.t), 3))
        j = int(self.model.vel_start[body])
        own = self._dynamics[0][:, j : j + 6 + int(self.model.n_mode[body])]
        return np.array([m.J_v @ a + m.a for m, a in zip(self.motions(marker), own, strict=True)])

    def reactions(self, rows: tuple[int, ...], side: int) -> Array:
        """Force and moment of joints on their first or second side, (k, 6), global [N, N m].

        Sum over the joint tables `rows` of the model, which have the same markers. Moments
        are about the marker of that side, 1 or 2.
        """
        return np.asarray(self._reactions[:, list(rows), side - 1].sum(axis=1))

    @cached_property
    def _dynamics(self) -> tuple[Array, Array]:
        """Accelerations (k, n_vel) and multipliers (k, n_c)."""
        found = [
            accelerations(self.model, assemble(self.model, t, y), y)
            for t, y in zip(self.t, self.y, strict=True)
        ]
        return np.array([a for a, _ in found]), np.array([m for _, m in found])

    @cached_property
    def _reactions(self) -> Array:
        """Force and moment of every joint on its two sides, (k, nj, 2, 6)."""
        states = zip(self.t, self.y, self._dynamics[1], strict=True)
        return np.array([joint_reactions(self.model, t, y, m) for t, y, m in states])
