"""The judgement of a run: every check in order, for single runs and members of sweeps alike."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from ..results.codes import Finding
from ..strength.found import BodyStrength
from . import balances, course, inputs, modes, stiffening
from .finished import FinishedRun

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
