"""What judges a run: all monitors as one while it runs, every check in order when it has ended."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from ..integrators.generic.drive import Steps, StopRequest
from ..math.arrays import Array
from ..results.codes import Finding
from ..strength.strength_summary import BodyStrength
from . import balances, course, inputs, modes, stiffening
from .finished_run import FinishedRun, StepSizes
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


Check = Callable[[FinishedRun], Iterable[Finding]]

# In the order in which their findings are shown. Strength comes last: what it computes is kept.
CHECKS: tuple[Check, ...] = (
    course.completion_findings,
    course.stall_findings,
    course.growth_findings,
    inputs.start_findings,
    balances.material_findings,
    balances.angle_findings,
    inputs.table_findings,
    course.refusal_findings,
    course.accuracy_findings,
    balances.constraint_findings,
    balances.energy_findings,
    balances.momentum_findings,
    modes.motion_findings,
    modes.mode_findings,
    stiffening.stiffening_findings,
    stiffening.undisturbed_findings,
    balances.package_findings,
)


class Judgement(NamedTuple):
    """What the checks say of a run."""

    findings: tuple[Finding, ...]
    numbers: dict[str, float | int]  # see FinishedRun.numbers
    strengths: dict[str, BodyStrength]  # of bodies whose packages have strengths

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the findings, each once."""
        return tuple(dict.fromkeys(finding.code for finding in self.findings))


def checked(run: FinishedRun) -> list[Finding]:
    """Return what the checks find in a finished run, without the search for the weakest ply."""
    return [finding for check in CHECKS for finding in check(run)]


def judge(run: FinishedRun) -> Judgement:
    """Apply every check to a finished run, and search for the weakest ply."""
    findings = checked(run)
    strengths = balances.body_strengths(run)
    findings += balances.strength_findings(strengths)
    return Judgement(tuple(findings), run.numbers(), strengths)
