"""The judgement of a run: every check in order, for single runs and members of sweeps alike."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ..results.finding import Finding
from ..strength.found import BodyStrength
from . import balances as constraints
from . import balances as energy
from . import balances as momentum
from . import bodies as materials
from . import bodies as packages
from . import bodies as strength
from . import course as completion
from . import course as growth
from . import course as refusals
from . import course as stalls
from . import modes, motion, start, stiffening, tables
from .finished import FinishedRun

Check = Callable[[FinishedRun], Iterable[Finding]]

# In the order in which their findings are shown. Strength comes last: what it computes is kept.
CHECKS: tuple[Check, ...] = (
    completion.completion_findings,
    stalls.stall_findings,
    growth.growth_findings,
    start.start_findings,
    materials.material_findings,
    tables.table_findings,
    refusals.refusal_findings,
    constraints.constraint_findings,
    energy.energy_findings,
    momentum.momentum_findings,
    motion.motion_findings,
    modes.mode_findings,
    stiffening.stiffening_findings,
    packages.package_findings,
)


@dataclass(frozen=True)
class Judgement:
    """What the checks say of a run."""

    findings: tuple[Finding, ...]
    numbers: dict[str, float | int]  # see FinishedRun.numbers
    strengths: dict[str, BodyStrength]  # of bodies whose packages have strengths

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the findings, each once."""
        return tuple(dict.fromkeys(finding.code for finding in self.findings))


def judge(run: FinishedRun) -> Judgement:
    """Apply every check to a finished run."""
    found = [finding for check in CHECKS for finding in check(run)]
    strengths = strength.body_strengths(run)
    found += strength.strength_findings(strengths)
    return Judgement(tuple(found), run.numbers(), strengths)
