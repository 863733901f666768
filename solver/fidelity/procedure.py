"""From an accuracy to a delivered result: plan, run of the model, check, promotion, refusal."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..package import ModalPackage
from ..package.body.selection import vibrations
from ..run.outcome import RunSpec
from .choice import chosen
from .exhausted import unseen
from .horizon import horizon
from .indicators import Study, study
from .model import check_plan
from .plan import BodyPlan, Plan, outline
from .shares import Share, promoted, split
from .trial import Trial, attempted, distance

RUNS = ("model", "check", "split")  # what planning spends time on, after the plan
ROUNDS = 4
MARGIN = 0.9  # of the accuracy: estimate up to which a request counts as met
SECOND_CHECK = 1.0 / 3.0  # of the accuracy: estimate from which a second check runs


@dataclass
class Answer:
    """A plan with what is known of it.

    Attributes
    ----------
    losses : (o,) by the indicators, of the scale
    estimate : (o,) by the check; None: not checked
    verdict : "planned", "met", "not met"
    horizon : time at which a change of 1e-6 has grown to the accuracy [s]; None: not in the run
    tried : name of the promotion, CPU time and signals (o, k) of each run on the way
    delivered : the run of the check, or of the model if there is none
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
    rounds: int = 0
    reason: str = ""
    horizon: float | None = None
    tried: list[tuple[str, float, Array]] = field(default_factory=list)

    @property
    def delivered(self) -> Trial | None:
        """The run whose result is delivered."""
        for trial in (self.check, self.trial):
            if trial is not None and trial.complete:
                return trial
        return self.check or self.trial


def flexible_names(spec: RunSpec) -> list[str]:
    """Return the flexible bodies that a plan is about: those that the case does not make rigid."""
    bodies = spec.mechanism.bodies
    return [n for n, b in bodies.items() if b.kind != "rigid" and not b.rigid]


def plan_of(spec: RunSpec, check: Mapping[str, ModalPackage]) -> Answer:
    """Return a plan from indicators alone, without the run of the model and the check.

    Parameters
    ----------
    spec : a run with `[fidelity]`, with the rich packages of its model
    check : the rich packages of its check

    Raises
    ------
    InputError
        A mechanism that cannot move.
    """
    fidelity = spec.mechanism.fidelity
    assert fidelity is not None
    signals = fidelity.signals or list(spec.mechanism.signals)
    names = flexible_names(spec)
    found = study(spec, check, names, signals)
    begin = time.process_time()
    kinds = {name: spec.mechanism.signals[name].kind for name in signals}
    least = {name: BodyPlan() for name in names}
    if found.base.reason:  # rigid bodies contradict each other
        for name in names:
            rows = vibrations(spec.packages[name])[:1]
            labels = tuple(spec.packages[name].mode_labels[i] for i in rows.tolist())
            least[name] = BodyPlan(labels, 6)
    plan, losses = chosen(found.indicators, found.model, fidelity.accuracy, kinds, least)
    cpu = {**found.cpu, "plan": time.process_time() - begin, **dict.fromkeys(RUNS, 0.0)}
    return Answer(spec, signals, found, plan, losses, cpu)


def checked(answer: Answer, *, promote: bool = True) -> Answer:
    """Run the model of a plan and its check; promote what is too coarse.

    `promote` is False for a plan that the user has edited: it is checked as it is.
    """
    fidelity = answer.spec.mechanism.fidelity
    assert fidelity is not None
    begin, budget = time.process_time(), fidelity.budget - sum(answer.cpu.values())

    def left() -> float:
        return budget - (time.process_time() - begin)

    def run(plan: Plan) -> Trial | None:
        if left() <= 0.0 and answer.check is not None:
            return None
        study = answer.study
        found = attempted(answer.spec, plan, study.model, study.check, answer.names)
        if found is not None and found.complete:
            answer.tried.append((outline(plan), found.cpu, found.signals))
        return found

    ranked = {name: answer.study.indicators.ranked(name) for name in answer.plan.bodies}
    while True:
        now = time.process_time()
        answer.trial = run(answer.plan) or answer.trial  # the first one whatever the budget
        answer.cpu["model"] += time.process_time() - now
        now = time.process_time()
        wanted = check_plan(answer.plan, ranked, answer.study.check)
        if answer.check is None or answer.check.plan != wanted:
            answer.check = run(wanted) or answer.check
        answer.cpu["check"] += time.process_time() - now
        answer.rounds += 1
        if answer.check is None:
            answer.reason = "no check: the budget is used up, or its model cannot be assembled"
            answer.verdict = "not met"
            return answer
        if answer.trial is None:
            answer.reason = "the model of the plan cannot be assembled"
            answer.verdict = "not met"
            return answer
        answer.estimate = distance(fidelity.metric, answer.trial, answer.check)
        estimate = float(answer.estimate.max(initial=0.0))
        if fidelity.accuracy * SECOND_CHECK < estimate <= MARGIN * fidelity.accuracy:
            estimate = _second(answer, ranked, run, fidelity.metric)
        blind, more = "", None
        if estimate <= MARGIN * fidelity.accuracy:
            now = time.process_time()
            both = answer.study.model, answer.study.check
            more, blind = unseen(answer.check, ranked, both, fidelity.metric, run)
            if more is not None:
                answer.estimate = np.hypot(answer.estimate, more)  # they peak at other times
                estimate = float(answer.estimate.max(initial=0.0))
            answer.cpu["check"] += time.process_time() - now
            if blind and more is None:
                answer.verdict = "not met"
                answer.reason = f"no package has more vibrations ({blind}), and no run shows what "
                answer.reason += "is missing above them: the budget is used up"
                return answer
        if estimate <= MARGIN * fidelity.accuracy:
            answer.verdict, answer.reason = "met", ""
            if fidelity.metric == "pointwise" and left() > 0.0:
                now = time.process_time()
                answer.horizon = horizon(answer.trial, answer.names, fidelity.accuracy)
                answer.cpu["horizon"] = time.process_time() - now
            return answer
        answer.verdict = "not met"
        answer.reason = f"the check differs by {estimate:.2g}"
        if blind:
            answer.reason = (
                f"no package has more vibrations ({blind}); with what is missing above them the "
                f"error is about {estimate:.2g}"
            )
            if more is not None and float(more.max()) > MARGIN * fidelity.accuracy:
                return answer  # more of the packages does not help
        if not promote or answer.rounds >= ROUNDS or left() <= 0.0:
            if left() <= 0.0:
                answer.reason += "; the budget is used up"
            return answer
        now = time.process_time()
        answer.shares = split(answer.trial, answer.check, ranked, fidelity.metric, run)
        answer.cpu["split"] += time.process_time() - now
        better = promoted(answer.plan, answer.check.plan, ranked, answer.shares, estimate)
        if better == answer.plan:
            answer.reason += "; nothing is left to promote"
            return answer
        answer.plan = better


def _second(answer: Answer, ranked: Mapping[str, tuple[str, ...]], run: Any, metric: str) -> float:
    """Compare with a richer check; return the larger estimate and deliver the richer run."""
    assert answer.trial is not None
    assert answer.estimate is not None
    begin = time.process_time()
    wanted = check_plan(answer.plan, ranked, answer.study.check, more=4)
    wanted = replace(wanted, rtol=0.3 * wanted.rtol)
    second = run(wanted)
    answer.cpu["check"] += time.process_time() - begin
    if second is not None and second.complete:
        answer.check = second
        again = distance(metric, answer.trial, second)
        answer.estimate = np.maximum(answer.estimate, again)
    return float(answer.estimate.max(initial=0.0))
