"""All monitors of a run as one watch."""

from dataclasses import dataclass

from ..integrators.generic import Steps, StopRequest
from .singularity import SingularityMonitor
from .spin import SpinMonitor


@dataclass
class Monitors:
    """Spin and singular positions; the latter also follows the energy balance."""

    spin: SpinMonitor
    passage: SingularityMonitor

    def __post_init__(self) -> None:
        self.passage.look_at_spins_above(self.spin.safe_spins())
        self.note = self.passage.note

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Show steps to all monitors; return the earliest of their requests."""
        spin = self.spin(steps)
        passage = self.passage(steps if spin is None else steps.until(spin.t_stop))
        requests = [request for request in (spin, passage) if request is not None]
        return min(requests, key=lambda request: request.t_stop, default=None)
