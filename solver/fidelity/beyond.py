"""Where a run leaves the range of its theory: no check of the same theory shows it."""

from ..checks.motion import motion_findings
from .trial import Trial


def beyond_theory(trial: Trial) -> list[str]:
    """Return, for each body that turns too far in itself, by how much and what to change."""
    return [finding.text for finding in motion_findings(trial.finished)]


def stopped(trial: Trial, what: str) -> str:
    """Return when and why a run ended early; "" if it did not."""
    if trial.complete:
        return ""
    solution = trial.finished.solution
    return f"the run of the {what} stopped at t = {solution.t[-1]:.4g} s ({solution.message})"
