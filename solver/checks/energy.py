"""The energy balance over the whole run."""

from collections.abc import Iterator

from ..results.codes.motion import ENERGY_DRIFT
from ..results.finding import Finding
from .finished import FinishedRun

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
