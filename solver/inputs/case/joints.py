"""`[joints.NAME]` of a case file: a table for each joint of dynamics/joints, made from its keys."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import AfterValidator, Field, create_model
from pydantic.fields import FieldInfo

from ...dynamics.joints.contract import Angle, Direction, DrivenBy, Joint, Key
from ...dynamics.joints.table import JOINTS
from ..common.keys import number_field
from ..common.table import Table, Vector, unit
from .laws import RotationDrive, TranslationDrive


def _of_some_length(vector: list[float]) -> list[float]:
    if not any(vector):
        raise ValueError("expected a vector of non-zero length")
    return vector


GlobalDirection = Annotated[Vector, AfterValidator(_of_some_length)]
Z = [0.0, 0.0, 1.0]


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
    default: Any = None
    if isinstance(key, DrivenBy):
        law: Any = RotationDrive if isinstance(key.drive.coordinate, Angle) else TranslationDrive
        drive: FieldInfo = Field(default=default, description=key.meaning)
        return law | None, drive
    if isinstance(key, Direction):
        default = ... if key.required else Z
        direction: FieldInfo = Field(
            default=default, description=key.meaning, json_schema_extra=unit("-")
        )
        return GlobalDirection, direction
    return number_field(key)


def _table(joint: Joint) -> type[JointTable]:
    fields: dict[str, Any] = {"kind": (Literal[joint.kind], ...)}
    fields |= {key.name: _field(key) for key in joint.keys}
    title = f'`[joints.NAME]` with kind = "{joint.kind}": {joint.meaning}.'
    name = f"{joint.kind.title().replace('_', '')}Joint"
    return create_model(name, __base__=JointTable, __doc__=title, **fields)


JOINT_TABLES: tuple[type[JointTable], ...] = tuple(_table(joint) for joint in JOINTS.values())
if TYPE_CHECKING:
    CaseJoint = JointTable
else:
    CaseJoint = Annotated[Union[(*JOINT_TABLES,)], Field(discriminator="kind")]


def drives(joint: JointTable) -> dict[str, RotationDrive | TranslationDrive]:
    """Return the drives of a joint by their keys."""
    names = [key.name for key in JOINTS[joint.kind].keys if isinstance(key, DrivenBy)]
    found = {name: getattr(joint, name) for name in names}
    return {name: drive for name, drive in found.items() if drive is not None}
