"""Which laws of time the joints and forces of a case have."""

from typing import TYPE_CHECKING

from ....dynamics.elements.forces.table import COORDINATE_FORCES, ELEMENTS, LOADS
from ....dynamics.elements.joints.contract import DrivenBy
from ....dynamics.elements.joints.table import JOINTS

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from ..tables.kinds import CoordinateTable, ForceTable, JointTable, LoadTable
    from ..tables.laws import LoadLaw, RotationDrive, TranslationDrive
    from ..tables.schema import Mechanism


def drives(joint: "JointTable") -> dict[str, "RotationDrive | TranslationDrive"]:
    """Return the drives of a joint by their keys."""
    names = [key.name for key in JOINTS[joint.kind].keys if isinstance(key, DrivenBy)]
    found = {name: getattr(joint, name) for name in names}
    return {name: drive for name, drive in found.items() if drive is not None}


def is_load(force: "ForceTable") -> "TypeIs[LoadTable]":
    """Whether a force comes from outside, at one place."""
    return force.kind in LOADS


def is_along(force: "ForceTable") -> "TypeIs[CoordinateTable]":
    """Whether a force acts along a coordinate."""
    return force.kind in COORDINATE_FORCES


def law(force: "ForceTable") -> "LoadLaw | None":
    """Return the law of a load, or of the actuator of an element if it has one."""
    if is_load(force):
        return force.law
    if is_along(force):
        return None
    laws = [getattr(force, key) for key in ELEMENTS[force.kind].laws]
    return laws[0] if laws else None


def is_smooth(mechanism: "Mechanism") -> bool:
    """Whether nothing in a mechanism may jump: no contact, feedback, expression or linear table."""
    laws: list[LoadLaw | RotationDrive | TranslationDrive | None] = []
    laws += [law(force) for force in mechanism.forces.values()]
    laws += [each for joint in mechanism.joints.values() for each in drives(joint).values()]
    return not any(is_along(force) for force in mechanism.forces.values()) and all(
        each is None
        or (each.expression is None and getattr(each.table, "interpolation", "") != "linear")
        for each in laws
    )
