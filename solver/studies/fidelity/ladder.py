"""The models between rigid bodies and all modes: error and CPU time of each, for a chart."""

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace

import numpy as np

from ...math.arrays import Array, front
from .answer import Answer
from .comparison import difference
from .plan import BodyPlan, Plan, number_of, vibration_labels
from .trial import Trial

COUNTS = (1, 2, 4)  # vibrations of each kind
STATIC = 4
TOLERANCES = (1e-3, 1e-4, 1e-5)


@dataclass(frozen=True)
class Rung:
    """One model: its name, CPU time of a run [s], error of its worst signal."""

    name: str
    cpu: float
    error: float


@dataclass(frozen=True)
class Ladder:
    """All models, compared with the tightest one, and the plan with its estimate."""

    rungs: list[Rung]
    chosen: Rung
    check: Rung
    estimate: float
    asked: float

    def entry(self) -> dict[str, object]:
        """Return plain data, as the report reads it."""
        return asdict(self)

    def front(self) -> list[Rung]:
        """Return the models of the Pareto front in time and error."""
        return [self.rungs[i] for i in front([(r.cpu, r.error) for r in self.rungs])]


def tried_models(answer: Answer) -> Ladder | None:
    """Return the models that planning has tried, compared with the check; None without a check."""
    pair = answer.trial, answer.check
    if answer.estimate is None or not all(trial and trial.complete for trial in pair):
        return None
    return _compared(answer, answer.pair[1], answer.tried)


def ladder(answer: Answer) -> Ladder:
    """Run the models of the ladder; `answer` has been checked.

    Errors are differences from the check with a third of its tolerance.
    """
    trials = [(name, answer.run(plan)) for name, plan in _plans(answer)]
    check = answer.pair[1]
    exact = answer.run(replace(check.plan, rtol=check.plan.rtol / 3.0)) or check
    trials_done = [(name, t.cpu, t.signals) for name, t in trials if t is not None and t.complete]
    return _compared(answer, exact, trials_done)


def _compared(answer: Answer, exact: Trial, tried: Iterable[tuple[str, float, Array]]) -> Ladder:
    """Return the ladder of models with their CPU times and signals; `exact` has no error."""
    fidelity, (model, check) = answer.spec.fidelity, answer.pair
    sizes = exact.scales(fidelity.metric)
    assert answer.estimate is not None

    def rung(name: str, cpu: float, signals: Array, *, complete: bool = True) -> Rung:
        error = float("inf")
        if complete and exact.complete:
            error = float(np.max(difference(fidelity.metric, signals, exact.signals) / sizes))
        return Rung(name, cpu, error)

    return Ladder(
        [rung(*one) for one in tried],
        rung("chosen", model.cpu, model.signals, complete=model.complete),
        rung("check", check.cpu, check.signals, complete=check.complete),
        float(answer.estimate.max(initial=0.0)),
        fidelity.accuracy,
    )


def _plans(answer: Answer) -> Iterator[tuple[str, Plan]]:
    known = {n: vibration_labels(rich.package) for n, rich in answer.study.model.items()}
    for count in (0, *COUNTS):
        for static in (0, STATIC) if count else (0,):
            bodies = {
                name: BodyPlan(tuple(x for x in labels if number_of(x) <= count), static)
                for name, labels in known.items()
            }
            label = f"{count} of each kind" if count else "rigid"
            shapes = ", static shapes" if static else ""
            for rtol in TOLERANCES:
                stiffening = answer.plan.stiffening and count > 0
                yield f"{label}{shapes}, rtol {rtol:g}", Plan(bodies, stiffening, rtol)
