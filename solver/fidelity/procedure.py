"""From an accuracy to a delivered result: plan, run of the model, check, promotion, refusal."""

from collections.abc import Mapping

from ..package import ModalPackage
from ..package.body.selection import vibrations
from ..run.outcome import RunSpec
from ..run.timing import work_s
from .answer import Answer
from .beyond import beyond_theory
from .checking import Checking
from .choice import chosen
from .indicators import study
from .model import STATIC
from .plan import BodyPlan
from .rounding import kind_of_signal

RUNS = ("model", "check", "split")  # what planning spends time on, after the plan
ROUNDS = 8  # most of them have no check of their own, and the budget ends them


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
    begin = work_s()
    kinds = {name: kind_of_signal(name, spec.mechanism.signals) for name in signals}
    least = {name: BodyPlan() for name in names}
    if found.base.reason:  # rigid bodies contradict each other
        for name in names:
            rows = vibrations(spec.packages[name])[:1]
            labels = tuple(spec.packages[name].mode_labels[i] for i in rows.tolist())
            least[name] = BodyPlan(labels, STATIC)
    plan, losses = chosen(found.indicators, found.model, fidelity.accuracy, kinds, least)
    cpu = {**found.cpu, "plan": work_s() - begin, **dict.fromkeys(RUNS, 0.0)}
    return Answer(spec, signals, found, plan, losses, cpu)


def checked(answer: Answer, *, promote: bool = True) -> Answer:
    """Run the model of a plan and its check; promote what is too coarse.

    `promote` is False for a plan that the user has edited: it is checked as it is.
    """
    fidelity = answer.spec.mechanism.fidelity
    assert fidelity is not None
    budget = fidelity.budget - sum(answer.cpu.values())
    checking = Checking(answer, fidelity.accuracy, fidelity.metric, budget, promote)
    if promote:
        checking.assemble()
    while not checking.settled():
        if checking.left() <= 0.0:
            answer.reason += "; the budget is used up"
            break
        if not promote or answer.rounds >= ROUNDS:
            break
        if not checking.promote():
            answer.reason += "; nothing is left to promote"
            break
    if answer.verdict != "met":
        checking.refuse()
    if answer.delivered is not None:
        answer.beyond = beyond_theory(answer.delivered)
    return answer
