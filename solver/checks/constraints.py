"""Constraints: whether joints hold together, leave freedom, and let the steps be long."""

from collections.abc import Iterator

from ..integrators.generic import advice
from ..results.codes.course import CONSTRAINT_DRIFT, FEEDBACK, LOCKED
from ..results.finding import Finding
from .finished import FinishedRun


def constraint_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield what the constraints make doubtful."""
    largest = run.past.position.value
    if largest > CONSTRAINT_DRIFT.limit:
        text = (
            f"joined points are up to {largest:.2g} m apart "
            f"(expected below {CONSTRAINT_DRIFT.limit:g} m): decrease rtol, or take "
            'constraints = "projection"'
        )
        yield CONSTRAINT_DRIFT.finding(text, t=run.past.position.t, value=largest)
    if run.degrees_of_freedom == 0:
        yield LOCKED.finding(
            "the mechanism has no degrees of freedom at t = 0: its bodies cannot move. Use "
            "flexible bodies, or joints that leave more freedom"
        )
    yield from _feedback(run)


def _feedback(run: FinishedRun) -> Iterator[Finding]:
    """Yield a note on a run whose steps the feedback of its constraints has kept short."""
    treatment, steps = run.treatment, run.solution.counters.steps
    rate = {
        "baumgarte": max(treatment.alpha, treatment.beta),
        "augmented-lagrangian": treatment.frequency * max(treatment.ratio, 1.0),
    }.get(treatment.name, 0.0)
    span = float(run.solution.t[-1])
    if steps < advice.STEPS_WORTH_A_LOOK or span == 0.0:
        return
    for text in advice.of_feedback(rate, span / steps, run.order):
        yield FEEDBACK.finding(text, value=rate * span / steps / run.order)
