"""All monitors of a run as one."""

from collections.abc import Callable
from dataclasses import dataclass, field

from ..integrators.generic.drive import Steps, StopRequest
from ..math.arrays import Array
from .finished import StepSizes
from .singularity import SingularityMonitor
from .stability import BucklingMonitor, SpinMonitor


@dataclass(eq=False, repr=False)
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
