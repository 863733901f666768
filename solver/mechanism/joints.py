"""Joints and their drives from the tables of a case."""

from dataclasses import dataclass

import numpy as np

from ..dynamics.tables import JointTable
from ..errors import InputError
from ..inputs.case.joints import Joint, drives
from ..inputs.case.laws import RotationDrive, TranslationDrive
from ..inputs.case.schema import Mechanism
from ..math.arrays import Array
from .laws import law_of, shifted
from .places import Places, axes

# Keys of a case that drive a joint -> kind of the drive by the kind of the joint.
_ROTATIONS = ("revolute", "planar")


@dataclass(frozen=True)
class BuiltJoint:
    """Where a joint of the case stands in the model."""

    kind: str
    rows: tuple[int, ...]  # joint tables of the model: the joint itself, then its drives
    shift: Array  # (3,) way from place one to two at the given start, in the joint's axes [m]


def joint_tables(
    mechanism: Mechanism, places: Places
) -> tuple[list[JointTable], dict[str, BuiltJoint]]:
    """Return the joints and drives, each drive behind its joint, and where they stand."""
    tables: list[JointTable] = []
    built = {}
    for name, joint in mechanism.joints.items():
        kind = joint.kind
        A_GM = axes(getattr(joint, "axis", None) or [0.0, 0.0, 1.0], getattr(joint, "axis_2", None))
        key = f"joints.{name}.between"
        one, two = (places.marker(key, place, A_GM) for place in joint.between)
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


def _drives(name: str, joint: Joint) -> list[tuple[str, str, RotationDrive | TranslationDrive]]:
    """Return kind, label and table of each drive of a joint."""
    words = {"rotation_drive": "rotation drive", "translation_drive": "translation drive"}
    found = []
    for key, drive in drives(joint).items():
        kind = key
        if key == "drive":
            kind = "rotation_drive" if joint.kind in _ROTATIONS else "translation_drive"
        found.append((kind, f"{name} ({words.get(key, key)})", drive))
    return found


def _length(name: str, joint: Joint, shift: Array) -> float:
    given = getattr(joint, "length", None)
    length = float(np.linalg.norm(shift)) if given is None else float(given)
    if length < 1e-9:
        raise InputError(
            f"joints.{name}: its places {joint.between} coincide at the start; expected a "
            "`length`, or a spherical joint"
        )
    return length
