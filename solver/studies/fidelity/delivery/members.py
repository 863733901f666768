"""One plan for all members of a sweep: made at the base, checked at some members."""

from collections.abc import Mapping
from dataclasses import replace

from ....package import ModalPackage
from ....run.outcome import RunSpec
from ..base.base import base_motion
from ..base.model import planned, vibration_labels
from ..base.plan import Plan
from ..check.answer import Answer
from ..indicators.loaded import fixed_packages, loaded
from .execution import checked, flexible_names, plan_of


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
    """Return the answer of a member for a given plan: its model and its check are run."""
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
    packages = {name: spec.packages[name] for name in names}
    rich = loaded(spec, base, packages, fixed_packages(spec, base, names)).rich
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
        )
    stiffening = one.stiffening or two.stiffening
    return replace(one, stiffening=stiffening, rtol=min(one.rtol, two.rtol))
