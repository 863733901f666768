"""Inputs of linearised equations: the drives, actuators and loads of a case."""

from typing import TYPE_CHECKING

from ...dynamics.elements.forces.contract import OfTime
from ...dynamics.elements.forces.table import ELEMENTS, LOADS
from ...dynamics.elements.joints.table import DRIVES, NAMES, position_rows
from ...inputs.case.expressions import drives
from ...mechanism import BuiltMechanism
from .state_space import Source

if TYPE_CHECKING:
    from ...inputs.case.tables.schema import Mechanism


def sources_of(mechanism: "Mechanism", built: BuiltMechanism) -> tuple[Source, ...]:
    """Return one input per law of time: "JOINT:DRIVE" by its acceleration, "FORCE" by its size."""
    model, found = built.model, []
    for name, joint in mechanism.joints.items():
        for key, row in zip(drives(joint), built.joints[name].rows[1:], strict=True):
            assert NAMES[model.joint_kind[row]] in DRIVES
            first = int(model.joint_row[row])
            unit = "m" if position_rows(model.joint_kind)[first] else "rad"
            found.append(Source(f"{name}:{key}", int(model.joint_law[row]), f"{unit}/s2", True))
    for k, (name, force) in enumerate(mechanism.forces.items()):
        law = int(model.force_law[k])
        if law >= 0:
            found.append(Source(name, law, _unit(force.kind), False))
    return tuple(found)


def _unit(kind: str) -> str:
    """Return the unit of the law of a force, which its meaning states in brackets."""
    if kind in LOADS:
        meaning = LOADS[kind].meaning
    else:
        meaning = next(key.meaning for key in ELEMENTS[kind].keys if isinstance(key, OfTime))
    return meaning.partition("[")[2].partition("]")[0]
