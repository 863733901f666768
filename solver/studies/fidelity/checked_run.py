"""A run, or the members of a sweep, with `[fidelity]`: plan, run, check, promotion, delivery."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ...package import ModalPackage
from ...results import RunResult, Summary
from ...run.execution import package_of, read_run
from ...run.inputs import RunSpec, inputs_sha256, plan_file, plan_sha256, still
from ...run.timing import Stopwatch, work_s
from .answer import Answer, beyond_theory, entry, remarks
from .checking import Checking
from .choice import chosen, kept_plan, write_plan
from .comparison import kind_of_signal
from .indicators.base_motion import base_motion, loaded
from .indicators.indicators import study
from .ladder import tried_models
from .plan import (
    STATIC,
    BodyPlan,
    Plan,
    flexible_names,
    known_vibrations,
    planned,
    vibration_labels,
)

RUNS = ("model", "check", "split")  # what planning spends time on, after the plan
ROUNDS = 8  # most of them have no check of their own, and the budget ends them


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
    fidelity = spec.fidelity
    signals = fidelity.signals or list(spec.mechanism.signals)
    names = flexible_names(spec)
    indicated = study(spec, check, names, signals)
    begin = work_s()
    kinds = {name: kind_of_signal(name, spec.mechanism.signals) for name in signals}
    least = {name: BodyPlan() for name in names}
    if indicated.base.reason:  # rigid bodies contradict each other
        for name in names:
            least[name] = BodyPlan(vibration_labels(spec.packages[name])[:1], STATIC)
    plan, losses = chosen(indicated.indicators, indicated.model, fidelity.accuracy, kinds, least)
    cpu = {**indicated.cpu, "plan": work_s() - begin, **dict.fromkeys(RUNS, 0.0)}
    return Answer(spec, signals, indicated, plan, losses, cpu)


def checked(answer: Answer, *, promote: bool = True) -> Answer:
    """Run the model of a plan and its check; promote what is too coarse.

    `promote` is False for a plan that the user has edited: it is checked as it is.
    """
    fidelity = answer.spec.fidelity
    budget = fidelity.budget - sum(answer.cpu.values())
    checking = Checking(answer, fidelity.accuracy, fidelity.metric, budget)
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
    if answer.delivered is not None:
        answer.beyond = beyond_theory(answer.delivered)
    return answer


def read_planned(
    file: Path, spec: RunSpec | None = None, *, allow_doubtful: bool = False
) -> tuple[RunSpec, dict[str, ModalPackage]]:
    """Read a run file with `[fidelity]`, its packages of the model and those of the check.

    Parameters
    ----------
    spec : the run, if it has been read
    allow_doubtful : as in `read_package`

    Raises
    ------
    InputError, PackageError
        See `read_run`.
    """
    spec = spec or read_run(file, allow_doubtful=allow_doubtful)
    table = json.loads(file.read_text(encoding="utf-8"))
    check = dict(spec.packages)  # bodies from files have one package
    for body, of_check in table.get("check_packages", {}).items():
        whose = f"the check of bodies.{body} of case {spec.case}, run {spec.run}"
        path = file.parent.parent / of_check["file"]
        check[body] = package_of(
            path,
            of_check.get("inputs_sha256"),
            whose,
            "run",
            allow_doubtful=allow_doubtful,
        )
    return spec, check


def answered(
    file: Path,
    *,
    again: bool = False,
    check: bool = True,
    spec: RunSpec | None = None,
    digest: str | None = None,
    allow_doubtful: bool = False,
) -> Answer:
    """Return the answer of a run with `[fidelity]`, and write its plan.

    A plan file of the same inputs is used as it is, whether it was edited or not.

    Parameters
    ----------
    again : make the plan again in any case
    check : run model and check
    spec, digest : what `read_run` and `inputs_sha256` return for the file, if known
    allow_doubtful : as in `read_package`
    """
    before = inputs_sha256(file) if digest is None else digest
    spec, packages = read_planned(file, spec, allow_doubtful=allow_doubtful)
    where = plan_file(file)
    digest = still(file, before)
    known = known_vibrations(spec, packages)
    of_file = plan_sha256(where)
    given = None if again or not digest else kept_plan(where, known, digest)
    answer = plan_of(spec, packages)
    if given is not None:
        answer.plan, answer.plan_sha256 = given, of_file
        return checked(answer, promote=False) if check else answer
    if check:
        answer = checked(answer)
    answer.plan = replace(answer.plan, inputs_sha256=digest)
    write_plan(where, answer.plan, remarks(answer))
    answer.plan_sha256 = plan_sha256(where)
    return answer


def delivered(
    file: Path, spec: RunSpec, digest: str, *, allow_doubtful: bool = False
) -> tuple[RunResult, Summary]:
    """Return result and summary of a run file with `[fidelity]`; see `run_file`.

    Parameters
    ----------
    spec, digest : what `read_run` and `inputs_sha256` return for the file
    """
    clock = Stopwatch()
    answer = answered(file, spec=spec, digest=digest, allow_doubtful=allow_doubtful)
    trial = answer.delivered
    assert trial is not None
    clock.lap("integrate")
    result, summary = trial.outcome()
    clock.lap("recover")
    summary["cost"]["seconds"] = clock.seconds
    tried = tried_models(answer)
    summary["fidelity"] = {
        **entry(answer),
        "plan_sha256": answer.plan_sha256,
        "ladder": tried.entry() if tried else None,
    }
    summary["inputs_sha256"] = answer.plan.inputs_sha256
    return result, summary


def shared_plan(spec: RunSpec, check: Mapping[str, ModalPackage]) -> Answer:
    """Return the answer of a base with a plan that needs the packages of the model alone.

    Members have no package of a check. Vibrations that only this package has are left out of the
    plan, and the plan is checked again.
    """
    answer = checked(plan_of(spec, check))
    plan = of_model(answer.plan, spec)
    return answer if plan == answer.plan else checked_member(spec, check, plan)


def of_model(plan: Plan, spec: RunSpec) -> Plan:
    """Return a plan with the modes that the packages of the model have."""
    for name, body in plan.bodies.items():
        known = vibration_labels(spec.packages[name])
        kept = tuple(label for label in body.vibrations if label in known)
        plan = plan.with_body(name, vibrations=kept, mesh="model")
    return plan


def checked_member(
    spec: RunSpec, check: Mapping[str, ModalPackage], plan: Plan, *, promote: bool = False
) -> Answer:
    """Return the answer of a member for a given plan: its model and its check are run.

    Parameters
    ----------
    spec : run of the member, with the rich packages of its model
    check : the rich packages of its check
    plan : of all members
    promote : as for `checked`: promote what is too coarse
    """
    answer = plan_of(spec, check)
    answer.plan = plan
    return checked(answer, promote=promote)


def member_spec(spec: RunSpec, plan: Plan) -> RunSpec:
    """Return a member with the model of a plan.

    Its static shapes are those of its own loads, from its own base motion.

    Raises
    ------
    InputError
        A member that cannot move.
    """
    names = flexible_names(spec)
    base = base_motion(spec, names)
    rich = loaded(spec, base, spec.packages, names).rich
    return planned(spec, plan, rich, rich)


def joined(one: Plan, two: Plan) -> Plan:
    """Return a plan that has what either of two has."""
    for name, body in two.bodies.items():
        own = one.bodies[name]
        one = one.with_body(
            name,
            vibrations=tuple(dict.fromkeys((*own.vibrations, *body.vibrations))),
            static=max(own.static, body.static),
            ringing=own.ringing or body.ringing,
            whole=own.whole or body.whole,
        )
    stiffening = one.stiffening or two.stiffening
    return replace(one, stiffening=stiffening, rtol=min(one.rtol, two.rtol))
