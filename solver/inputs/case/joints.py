"""`[joints.NAME]` of a case file: a table for each joint of dynamics/elements/joints, made from its
keys."""

from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Field
from pydantic.fields import FieldInfo

from ...dynamics.elements.joints.contract import Angle, DrivenBy, Joint, Key
from ...dynamics.elements.joints.table import JOINTS
from ..common.table import Table
from .keys import field_of, table_of
from .laws import RotationDrive, TranslationDrive


class JointTable(Table):
    """Keys of every joint."""

    between: list[str] = Field(
        min_length=2,
        max_length=2,
        description='two places: "BODY.INTERFACE" or "ground.POINT"; motion is that of the second '
        "relative to the first",
    )
    kind: str


def _field(key: Key) -> tuple[Any, FieldInfo]:
    """Return type and field of a key."""
    if isinstance(key, DrivenBy):
        law: Any = RotationDrive if isinstance(key.drive.coordinate, Angle) else TranslationDrive
        default: Any = None
        drive: FieldInfo = Field(default=default, description=key.meaning)
        return law | None, drive
    return field_of(key)


def _table(joint: Joint) -> type[JointTable]:
    fields = {key.name: _field(key) for key in joint.keys}
    return table_of(JointTable, "joints", joint.kind, f"{joint.meaning}.", fields)


JOINT_TABLES: tuple[type[JointTable], ...] = tuple(_table(joint) for joint in JOINTS.values())
if TYPE_CHECKING:
    CaseJoint = JointTable
else:
    CaseJoint = Annotated[Union[(*JOINT_TABLES,)], Field(discriminator="kind")]
