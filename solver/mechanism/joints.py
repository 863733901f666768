"""Joints and their drives from the tables of a case."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..dynamics.joints.contract import Displacement, DrivenBy, Number
from ..dynamics.joints.table import JOINTS
from ..dynamics.tables import JointTable
from ..errors import InputError
from ..inputs.case.of_time import drives
from ..math.arrays import Array
from .laws import drive_law, shifted
from .places import Places, axes

if TYPE_CHECKING:
    from ..inputs.case.joints import CaseJoint
    from ..inputs.case.schema import Mechanism


@dataclass(frozen=True)
class BuiltJoint:
    """Position of a joint of the case in the model."""

    kind: str
    rows: tuple[int, ...]  # joint tables of the model: the joint itself, then its drives
    shift: Array  # (3,) vector from place one to two at the given start, in the joint's axes [m]


def joint_tables(
    mechanism: "Mechanism", places: Places
) -> tuple[list[JointTable], dict[str, BuiltJoint]]:
    """Return the joints and drives, each drive after its joint, and their positions in the
    model."""
    tables: list[JointTable] = []
    built = {}
    for name, joint in mechanism.joints.items():
        kind = joint.kind
        A_GM = axes(getattr(joint, "axis", None) or [0.0, 0.0, 1.0], getattr(joint, "axis_2", None))
        key = f"joints.{name}.between"
        one, two = (places.marker(key, place, A_GM) for place in joint.between)
        shift = places.shift(one, two)
        first = len(tables)
        tables.append(JointTable(name, kind, one, two, parameters=_numbers(name, joint, shift)))
        driven_by = {key.name: key for key in JOINTS[kind].keys if isinstance(key, DrivenBy)}
        for drive_key, drive in drives(joint).items():
            driven = driven_by[drive_key].drive
            coordinate = driven.coordinate
            start = shift[coordinate.axis] if isinstance(coordinate, Displacement) else 0.0
            given = drive_law(drive, mechanism, f"joints.{name}.{drive_key}")
            law = shifted(given, float(start))
            label = f"{name} ({drive_key.replace('_', ' ')})"
            tables.append(JointTable(label, driven.kind, one, two, law))
        built[name] = BuiltJoint(kind, tuple(range(first, len(tables))), shift)
    return tables, built


def _numbers(name: str, joint: "CaseJoint", shift: Array) -> tuple[float, ...]:
    """Return the numbers of a joint in the order of its kernel."""
    kind = JOINTS[joint.kind]
    given = {key.name: getattr(joint, key.name) for key in kind.keys if isinstance(key, Number)}
    given["between"] = joint.between
    try:
        complete = kind.complete(given, shift)
    except InputError as error:
        raise InputError(f"joints.{name}{error}") from error
    return tuple(complete[key] for key in kind.parameters)
