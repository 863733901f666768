"""The plan of a sweep with [fidelity], as its members read it."""

from collections.abc import Mapping

from ...errors import InputError
from ...inputs.case.bodies.segments import in_segments
from ...inputs.case.tables.schema import Mechanism
from ...package import ModalPackage
from ...run.outcome import RunSpec
from ..fidelity.base.model import vibration_labels
from ..fidelity.base.plan import Plan as ModelPlan
from ..fidelity.choice.plan_file import read_plan
from ..fidelity.delivery.execution import flexible_names
from .plan import Plan


def model_plan(plan: Plan, packages: Mapping[str, ModalPackage]) -> ModelPlan:
    """Return the plan that the command has written; `packages` are those of the base.

    Raises
    ------
    InputError
        There is none, or it is wrong.
    """
    file = plan.model_plan_file
    if not file.is_file():
        raise InputError(f"{file}: no such file; expected the plan that `plymotion sweep` makes")
    base = RunSpec(plan.case, plan.run, base_mechanism(plan), dict(packages))
    return read_plan(file, known_vibrations(base))


def base_mechanism(plan: Plan) -> Mechanism:
    """Return the run that members change, in the bodies that are built."""
    return in_segments(plan.mechanism)


def known_vibrations(base: RunSpec) -> dict[str, dict[str, tuple[str, ...]]]:
    """Return the vibrations that a plan may name: members have packages of the model only."""
    return {
        name: {"model": vibration_labels(base.packages[name]), "check": ()}
        for name in flexible_names(base)
    }
