"""Joints and their drives from the tables of a case."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..dynamics.tables import JointTable
from ..errors import InputError
from ..math.arrays import Array
from .laws import law_of, shifted
from .places import Places, axes

# Keys of a case that drive a joint -> kind of the drive by the kind of the joint.
_ROTATIONS = ("revolute", "planar")


@dataclass(frozen=True)
class BuiltJoint:
    """Position of a joint of the case in the model."""

    kind: str
    rows: tuple[int, ...]  # joint tables of the model: the joint itself, then its drives
    shift: Array  # (3,) vector from place one to two at the given start, in the joint's axes [m]


def joint_tables(
    mechanism: dict[str, Any], places: Places
) -> tuple[list[JointTable], dict[str, BuiltJoint]]:
    """Return the joints and drives, each drive after its joint, and their positions in the
    model."""
    tables: list[JointTable] = []
    built = {}
    for name, joint in mechanism["joints"].items():
        kind = joint["kind"]
        A_GM = axes(joint.get("axis") or [0.0, 0.0, 1.0], joint.get("axis_2"))
        key = f"joints.{name}.between"
        one, two = (places.marker(key, place, A_GM) for place in joint["between"])
        shift = places.shift(one, two)
        length = _length(name, joint, shift) if kind == "distance" else 0.0
        first = len(tables)
        tables.append(JointTable(name, kind, one, two, length=length))
        for drive_kind, label, drive in _drives(name, joint):
            start = shift[2] if drive_kind == "translation_drive" else 0.0
            law = shifted(law_of(drive), float(start))
            tables.append(JointTable(label, drive_kind, one, two, law))
        built[name] = BuiltJoint(kind, tuple(range(first, len(tables))), shift)
    return tables, built


def _drives(name: str, joint: dict[str, Any]) -> list[tuple[str, str, dict[str, Any]]]:
    """Return kind, label and table of each drive of a joint."""
    found = []
    if joint.get("drive") is not None:
        kind = "rotation_drive" if joint["kind"] in _ROTATIONS else "translation_drive"
        found.append((kind, f"{name} (drive)", joint["drive"]))
    for kind, word in (("rotation_drive", "rotation"), ("translation_drive", "translation")):
        if joint.get(kind) is not None:
            found.append((kind, f"{name} ({word} drive)", joint[kind]))
    return found


def _length(name: str, joint: dict[str, Any], shift: Array) -> float:
    length = float(np.linalg.norm(shift)) if joint["length"] is None else float(joint["length"])
    if length < 1e-9:
        raise InputError(
            f"joints.{name}: its places {joint['between']} coincide at the start; expected a "
            "`length`, or a spherical joint"
        )
    return length
