"""All monitors of a run as one, and the number of steps of each size."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..integrators.generic.drive import Steps, StopRequest
from ..math.arrays import Array
from .singularity import SingularityMonitor
from .stability import BucklingMonitor, SpinMonitor

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


@dataclass
class Monitors:
    """Spin, buckling and singular positions; the latter also follows the energy balance."""

    spin: SpinMonitor
    passage: SingularityMonitor
    buckling: BucklingMonitor | None = None
    follow: Callable[[Array, Array], None] | None = None  # gets the ends of all steps: t, y
    sizes: StepSizes = field(default_factory=StepSizes)

    def __post_init__(self) -> None:
        self.passage.look_at_spins_above(self.spin.safe_spin)
        self.note = self.passage.note

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Show steps to all monitors; return the earliest of their requests."""
        self.sizes.take(steps)
        requests: list[StopRequest] = []
        for monitor in (self.spin, self.buckling, self.passage):
            request = None if monitor is None else monitor(steps)
            if request is not None:
                requests.append(request)
                steps = steps.until(request.t_stop)
        if self.follow is not None:
            self.follow(steps.t, steps.y)
        return min(requests, key=lambda request: request.t_stop, default=None)
