"""The models between rigid bodies and all modes: error and CPU time of each, for a chart."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...math.arrays import Array, front
from ...package.body.selection import vibrations
from .answer import Answer
from .motions import difference
from .plan import BodyPlan, Plan
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
    fidelity, check, trial = answer.spec.mechanism.fidelity, answer.check, answer.trial
    if fidelity is None or check is None or trial is None or answer.estimate is None:
        return None
    if not (check.complete and trial.complete):
        return None
    sizes = check.scales(fidelity.metric)

    def error(signals: Array) -> float:
        return float(np.max(difference(fidelity.metric, signals, check.signals) / sizes))

    rungs = [Rung(name, cpu, error(signals)) for name, cpu, signals in answer.tried]
    return Ladder(
        rungs,
        Rung("chosen", trial.cpu, error(trial.signals)),
        Rung("check", check.cpu, 0.0),
        float(answer.estimate.max(initial=0.0)),
        fidelity.accuracy,
    )


def ladder(answer: Answer) -> Ladder:
    """Run the models of the ladder; `answer` has been checked.

    Errors are differences from the tightest model: all vibrations and load shapes of the check
    packages, undamped, with rtol a third of that of the check.
    """
    assert answer.trial is not None
    assert answer.check is not None
    assert answer.estimate is not None
    fidelity = answer.spec.mechanism.fidelity
    assert fidelity is not None
    exact = _run(answer, _everything(answer)) or answer.check
    sizes = exact.scales(fidelity.metric)

    def rung(name: str, trial: Trial) -> Rung:
        error = _largest(fidelity.metric, trial, exact, sizes)
        return Rung(name, trial.cpu, error)

    rungs = []
    for name, plan in _plans(answer):
        trial = _run(answer, plan)
        if trial is not None and trial.complete:
            rungs.append(rung(name, trial))
    return Ladder(
        rungs,
        rung("chosen", answer.trial),
        rung("check", answer.check),
        float(answer.estimate.max(initial=0.0)),
        fidelity.accuracy,
    )


def _largest(metric: str, trial: Trial, exact: Trial, sizes: Array) -> float:
    if not (trial.complete and exact.complete):
        return float("inf")
    return float(np.max(difference(metric, trial.signals, exact.signals) / sizes))


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
    package = answer.study.model[name].package
    labels = [package.mode_labels[i] for i in vibrations(package).tolist()]
    kinds: dict[str, list[str]] = {}
    for label in labels:
        kinds.setdefault(label.rpartition(" ")[0], []).append(label)
    kept = {label for group in kinds.values() for label in group[:count]}
    return tuple(label for label in labels if label in kept)


def _everything(answer: Answer) -> Plan:
    assert answer.check is not None
    bodies = {}
    for name in answer.plan.bodies:
        package = answer.study.check[name].package
        labels = tuple(package.mode_labels[i] for i in vibrations(package).tolist())
        bodies[name] = BodyPlan(labels, 10, True, "check")
    tight = answer.check.plan
    return Plan(bodies, tight.stiffening, tight.rtol / 3.0)
