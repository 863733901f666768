"""Data of a run for sensors: states at the output times, and quantities computed on demand."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from ...math.arrays import Array
from ..evaluation import series
from ..model.model import Model
from ..model.motion import ACCELERATION, AXES, PLACE, SPIN, SPIN_RATE, VELOCITY

MARKERS = 32  # whose motions are kept: signals of a place follow each other


class Recording:
    """States y (k, n) of a model at times t (k,); each quantity is computed once.

    Of a long run it is one block after the other: `memory` is what sensors keep of earlier ones,
    the same for all blocks.
    """

    def __init__(
        self, model: Model, t: Array, y: Array, memory: dict[Any, Any] | None = None
    ) -> None:
        self.model, self.t, self.y = model, t, y
        self.memory = {} if memory is None else memory
        self._motions: dict[int, Array] = {}
        self._carried: dict[Any, Array] = {}
        self._shared: dict[Any, Array] = {}

    def carried(self, key: Any, compute: Callable[[Any], tuple[Array, Any]]) -> Array:
        """Return values (k, ...) that depend on those of the block before.

        `compute` gets what it kept of the block before under this key, None in the first; it
        returns the values and what it keeps for the next.
        """
        if key not in self._carried:
            self._carried[key], self.memory[key] = compute(self.memory.get(key))
        return self._carried[key]

    def position(self, marker: int) -> Array:
        """Position (k, 3) of a marker's origin, global [m]."""
        return self._motion(marker)[:, PLACE:AXES]

    def axes(self, marker: int) -> Array:
        """Axes of a marker in columns, global, (k, 3, 3)."""
        return self._motion(marker)[:, AXES:VELOCITY].reshape(-1, 3, 3)

    def velocity(self, marker: int) -> Array:
        """Velocity (k, 3) of a marker's origin, global [m/s]."""
        return self._motion(marker)[:, VELOCITY:SPIN]

    def spin(self, marker: int) -> Array:
        """Angular velocity (k, 3) of a marker, global [rad/s]."""
        return self._motion(marker)[:, SPIN:ACCELERATION]

    def _motion(self, marker: int) -> Array:
        """Row of dynamics/model/motion.py of a marker in every state, (k, 24)."""
        if marker not in self._motions:
            if len(self._motions) >= MARKERS:
                self._motions.pop(next(iter(self._motions)))
            self._motions[marker], _ = series.marker_motions(self.model, marker, self.y)
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
        j = self.model.n_pos + int(self.model.vel_start[body])
        own = self.rates[:, j : j + 6 + int(self.model.n_mode[body])]
        motion, J_m = series.marker_motions(self.model, marker, self.y)
        return np.asarray(
            np.einsum("kan,kn->ka", J_m[:, :3], own) + motion[:, ACCELERATION:SPIN_RATE]
        )

    def reactions(self, rows: tuple[int, ...], side: int) -> Array:
        """Force and moment of joints on their first or second side, (k, 6), global [N, N m].

        Sum over the joint tables `rows` of the model, which have the same markers. Moments
        are about the marker of that side, 1 or 2.
        """
        return self.loads([2 * row + side - 1 for row in rows]).sum(axis=1)

    def loads(self, places: list[int]) -> Array:
        """Force and moment (k, n, 6) of places of `series.loaded_markers`, global [N, N m]."""
        return np.asarray(self._loads[:, places])

    def once(self, key: Any, compute: Callable[[], Array]) -> Array:
        """Return values (k, ...) that several signals of these times need."""
        if key not in self._shared:
            self._shared[key] = compute()
        return self._shared[key]

    @property
    def rates(self) -> Array:
        """Rates (k, n) of the states."""
        return self.along.rates

    @property
    def multipliers(self) -> Array:
        """Multipliers (k, n_c) of the constraints."""
        return self.along.multipliers

    @cached_property
    def along(self) -> series.Along:
        """Rates, multipliers, constraints and energies."""
        return series.along(self.model, self.t, self.y)

    @cached_property
    def _loads(self) -> Array:
        """Force and moment of every joint on its two sides, (k, 2 nj, 6), and of force elements."""
        return series.marker_loads(self.model, self.t, self.y, self.multipliers)
