"""Sizes of the accepted steps of a run, as counts by powers of two."""

from dataclasses import dataclass, field

import numpy as np

from ...integrators.generic.drive import Steps
from ...math.arrays import Array

LEAST, MOST = -200, 200  # exponents of two


@dataclass
class StepSizes:
    """How many steps of each size a run has taken."""

    _count: Array = field(default_factory=lambda: np.zeros(MOST - LEAST + 1))
    _time: Array = field(default_factory=lambda: np.zeros(MOST - LEAST + 1))  # [s]

    def take(self, steps: Steps) -> None:
        """Take the steps after the last ones."""
        h = np.diff(steps.t)
        h = h[h > 0.0]
        place = np.clip(np.frexp(h)[1], LEAST, MOST) - LEAST
        np.add.at(self._count, place, 1.0)
        np.add.at(self._time, place, h)

    def steps_with(self, max_step: float) -> float:
        """Return about how many steps the run would take with no step above `max_step` [s]."""
        return float(np.maximum(self._count, self._time / max_step).sum())
