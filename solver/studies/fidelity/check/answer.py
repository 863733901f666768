"""The outcome of a plan: its model, its check, the verdict, the run that is delivered."""

from dataclasses import dataclass, field

import numpy as np

from ....checks.modes import motion_findings
from ....math.arrays import Array
from ....run.outcome import RunSpec
from ..base.plan import Plan
from ..indicators.indicators import Study
from .shares import Share
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


@dataclass
class Answer:
    """A plan with what is known of it.

    Attributes
    ----------
    losses : (o,) by the indicators, of the scale
    estimate : (o,) error of the model of the plan, by the check; None: not checked
    verdict : "planned", "met", "not met"
    horizon : time at which a change of 1e-6 has grown to the accuracy [s]; None: not in the run
    tried : name of the promotion, CPU time and signals (o, k) of each run on the way
    finest : of a request that is not met, the run with all modes of the package of the check
    beyond : where the delivered run leaves the range of the theory, in words
    plan_sha256 : of the plan as it was read from its file, or written there
    delivered : the finest run, or that of the check, or of the model if there is none
    """

    spec: RunSpec
    names: list[str]
    study: Study
    plan: Plan
    losses: Array
    cpu: dict[str, float]
    estimate: Array | None = None
    verdict: str = "planned"
    shares: list[Share] = field(default_factory=list)
    trial: Trial | None = None
    check: Trial | None = None
    finest: Trial | None = None
    rounds: int = 0
    reason: str = ""
    horizon: float | None = None
    tried: list[tuple[str, float, Array]] = field(default_factory=list)
    beyond: list[str] = field(default_factory=list)
    plan_sha256: str = ""

    @property
    def estimates(self) -> dict[str, float]:
        """Estimated errors of the model by signal; infinite if a run ended early; none: not
        checked."""
        if self.estimate is None:
            return {}
        return dict(zip(self.names, self.estimate.tolist(), strict=True))

    @property
    def delivered(self) -> Trial | None:
        """The run whose result is delivered."""
        for trial in (self.finest, self.check, self.trial):
            if trial is not None and trial.complete:
                return trial
        return self.check or self.trial

    @property
    def delivered_name(self) -> str:
        """Which run is delivered: "model", "check" or "all modes"."""
        names = ((self.finest, "all modes"), (self.check, "check"), (self.trial, "model"))
        return next((name for trial, name in names if trial and trial is self.delivered), "none")

    @property
    def delivered_at_most(self) -> dict[str, float | None]:
        """What the error of the delivered run is at most, by signal; None: not estimated.

        The check has more of everything than the model, so that its error is smaller. How much
        smaller, no run tells. A run that no other one was compared with has no estimate.
        """
        richer = self.finest is not None or self.delivered is self.check
        known = self.estimates if richer else {}
        return {
            name: known[name] if np.isfinite(known.get(name, np.inf)) else None
            for name in self.names
        }
