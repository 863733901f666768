"""Loads and reactions against the change of momentum of each body."""

from collections.abc import Iterator

from ..results.codes.motion import MOMENTUM
from ..results.finding import Finding
from .finished import FinishedRun


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
