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
    by = f" by `{solution.code}`" if solution.code else ""
    return f"the run of the {what} stopped at t = {solution.t[-1]:.4g} s{by} ({solution.message})"


def not_compared(model: Trial, check: Trial) -> str:
    """Return why model and check could not be compared; "" if both reached the end."""
    found = [stopped(check, "check"), stopped(model, "model")]
    if found[0] and model.complete:
        found.append("the run of the model did not, so that its error is not known")
    return "; ".join(text for text in found if text)
