"""Balances of a run: constraints, energy, and the momentum of each body."""

from collections.abc import Iterator

from ..integrators.generic import advice
from ..results.codes import CONSTRAINT_DRIFT, ENERGY_DRIFT, FEEDBACK, LOCKED, MOMENTUM, Finding
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


INSIDE = 0.1  # of the energy taken out of vibrations


def energy_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield a finding if energy less work drifts; a locked mechanism has none to balance."""
    largest = run.past.energy_drift
    # Inside a step, the state between two ends has lost another part than the whole step.
    between = INSIDE * abs(run.solution.damped_energy) / run.past.energy_in_play
    if largest <= ENERGY_DRIFT.limit + between or run.degrees_of_freedom == 0:
        return
    text = (
        f"the energy balance is off by {largest:.2g} of the energy "
        f"in play (expected below {ENERGY_DRIFT.limit:g}): decrease rtol"
    )
    yield ENERGY_DRIFT.finding(text, t=run.past.balance.t, value=largest)


def momentum_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield a finding if the reactions do not balance the change of momentum."""
    error = run.momentum_balance
    if error > MOMENTUM.limit:
        text = (
            "loads and reactions miss the change of momentum by "
            f"{error:.2g} of the largest force (expected below "
            f"{MOMENTUM.limit:g}): do not trust the reactions"
        )
        yield MOMENTUM.finding(text, value=error)
