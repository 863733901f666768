"""The models between rigid bodies and all modes: error and CPU time of each, for a chart."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...math.arrays import Array, front
from .answer import Answer
from .motions import difference
from .plan import BodyPlan, Plan, kind_of, vibration_labels
from .trial import Trial, attempted

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

    def entry(self) -> dict[str, Any]:
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

    Errors are differences from the tightest model: all vibrations and load shapes of the check
    packages, undamped, with rtol a third of that of the check.
    """
    trials = [(name, _run(answer, plan)) for name, plan in _plans(answer)]
    found = [(name, t.cpu, t.signals) for name, t in trials if t is not None and t.complete]
    return _compared(answer, _run(answer, _everything(answer)) or answer.pair[1], found)


def _compared(answer: Answer, exact: Trial, tried: Iterable[tuple[str, float, Array]]) -> Ladder:
    """Return the ladder of models with their CPU times and signals; `exact` has no error."""
    fidelity, (model, check) = answer.spec.fidelity, answer.pair
    sizes = exact.scales(fidelity.metric)
    assert answer.estimate is not None

    def rung(name: str, cpu: float, signals: Array, *, complete: bool = exact.complete) -> Rung:
        if not complete:
            return Rung(name, cpu, float("inf"))
        error = difference(fidelity.metric, signals, exact.signals) / sizes
        return Rung(name, cpu, float(np.max(error)))

    def of(name: str, trial: Trial) -> Rung:
        complete = trial.complete and exact.complete
        return rung(name, trial.cpu, trial.signals, complete=complete)

    return Ladder(
        [rung(*one) for one in tried],
        of("chosen", model),
        of("check", check),
        float(answer.estimate.max(initial=0.0)),
        fidelity.accuracy,
    )


def _run(answer: Answer, plan: Plan) -> Trial | None:
    found = answer.study
    return attempted(
        answer.spec, plan, found.model, found.check, answer.names, found.indicators.quiet
    )


def _plans(answer: Answer) -> list[tuple[str, Plan]]:
    bodies = list(answer.plan.bodies)
    found = [
        (f"rigid, rtol {rtol:g}", Plan({name: BodyPlan() for name in bodies}, False, rtol))
        for rtol in TOLERANCES
    ]
    for count in COUNTS:
        for static in (0, STATIC):
            shapes = ", static shapes" if static else ""
            for rtol in TOLERANCES:
                some = {name: BodyPlan(_lowest(answer, name, count), static) for name in bodies}
                name = f"{count} of each kind{shapes}, rtol {rtol:g}"
                found.append((name, Plan(some, answer.plan.stiffening, rtol)))
    return found


def _lowest(answer: Answer, name: str, count: int) -> tuple[str, ...]:
    labels = vibration_labels(answer.study.model[name].package)
    kinds: dict[str, list[str]] = {}
    for label in labels:
        kinds.setdefault(kind_of(label), []).append(label)
    kept = {label for group in kinds.values() for label in group[:count]}
    return tuple(label for label in labels if label in kept)


def _everything(answer: Answer) -> Plan:
    bodies = {
        name: BodyPlan(vibration_labels(answer.study.check[name].package), 10, True, "check")
        for name in answer.plan.bodies
    }
    tight = answer.pair[1].plan
    return Plan(bodies, tight.stiffening, tight.rtol / 3.0)
