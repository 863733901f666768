"""Tables of joints, couplings and forces of a case, made from the keys of their kinds."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, Union

from pydantic import AfterValidator, Field, create_model, model_validator
from pydantic.fields import FieldInfo

from ....dynamics.elements.couplings.contract import Coupling
from ....dynamics.elements.couplings.table import COUPLINGS
from ....dynamics.elements.forces.contract import CoordinateForce, Element, ForceElement, Load
from ....dynamics.elements.forces.table import FORCES
from ....dynamics.elements.joints.contract import Angle, DrivenBy, Joint
from ....dynamics.elements.joints.contract import Key as JointKey
from ....dynamics.elements.joints.table import JOINTS
from ....math.keys import Code, Curve, Direction, Expression, Expressions, Number, OfTime, Three
from ...common.table import Axis, Name, Table, unit
from .laws import CurveTable, LoadLaw, RotationDrive, TranslationDrive
from .python_code import PythonCode
from .signals import JointCoordinate

Kind = TypeVar("Kind", bound=Table)
Z = [0.0, 0.0, 1.0]
NONE = [0.0, 0.0, 0.0]


def _not_zero(value: float | None) -> float | None:
    if value == 0.0:
        raise ValueError("expected a number other than 0")
    return value


Constants = Annotated[list[Annotated[float, Field(ge=0)]], Field(min_length=3, max_length=3)]


Key = Number | Three | Direction | OfTime | Expression | Expressions | Curve | Code


def table_of(
    base: type[Kind], group: str, kind: str, meaning: str, fields: Mapping[str, Any]
) -> type[Kind]:
    """Return the table `[group.NAME]` of one kind: the keys of `base` and its own fields."""
    text = f'`[{group}.NAME]` with kind = "{kind}": {meaning}'
    name = f"{kind.title().replace('_', '')}{group.removesuffix('s').title()}"
    own: dict[str, Any] = {"kind": (Literal[kind], ...), **fields}
    return create_model(name, __base__=base, __doc__=text, **own)


def field_of(key: Key) -> tuple[Any, FieldInfo]:
    """Return type and field of a key, as `create_model` takes them."""
    if isinstance(key, Number):
        return _number(key)
    default: Any = None
    if isinstance(key, Expressions):
        texts: FieldInfo = Field(min_length=1, description=key.meaning)
        return list[str], texts
    if isinstance(key, Code):
        code: FieldInfo = Field(description=key.meaning)
        return PythonCode, code
    if isinstance(key, Curve):
        points: FieldInfo = Field(
            default=default, description=key.meaning, json_schema_extra=unit(key.unit)
        )
        return CurveTable | None, points
    if isinstance(key, Expression):
        given: Any = ... if key.required else key.default
        text: FieldInfo = Field(
            default=given, description=key.meaning, json_schema_extra=unit(key.unit)
        )
        return (str | None if given is None else str), text
    if isinstance(key, OfTime):
        return LoadLaw | None, Field(default=default, description=key.meaning)
    if isinstance(key, Three):
        kind, symbol, default = Constants, key.unit, NONE
    else:
        kind, symbol = Axis, "-"
        default = None if key.absent else Z
    default = ... if key.required else default
    found: FieldInfo = Field(
        default=default, description=key.meaning, json_schema_extra=unit(symbol)
    )
    return (kind | None if default is None else kind), found


def _number(key: Number) -> tuple[Any, FieldInfo]:
    default: Any = ... if key.required else key.default
    number: FieldInfo = Field(
        default=default,
        gt=key.above,
        ge=key.least,
        le=key.most,
        description=key.meaning,
        json_schema_extra=unit(key.unit),
    )
    kind: Any = int if key.integer else float
    if default is None:
        kind = kind | None
    return (Annotated[kind, AfterValidator(_not_zero)] if key.not_zero else kind), number


class JointTable(Table):
    """Keys of every joint."""

    between: list[str] = Field(
        min_length=2,
        max_length=2,
        description='two places: "BODY.INTERFACE" or "ground.POINT"; motion is that of the second '
        "relative to the first",
    )
    kind: str


def _field(key: JointKey) -> tuple[Any, FieldInfo]:
    """Return type and field of a key."""
    if isinstance(key, DrivenBy):
        law: Any = RotationDrive if isinstance(key.drive.coordinate, Angle) else TranslationDrive
        default: Any = None
        drive: FieldInfo = Field(default=default, description=key.meaning)
        return law | None, drive
    return field_of(key)


def _joint_table(joint: Joint) -> type[JointTable]:
    fields = {key.name: _field(key) for key in joint.keys}
    return table_of(JointTable, "joints", joint.kind, f"{joint.meaning}.", fields)


JOINT_TABLES: tuple[type[JointTable], ...] = tuple(_joint_table(joint) for joint in JOINTS.values())
if TYPE_CHECKING:
    CaseJoint = JointTable
else:
    CaseJoint = Annotated[Union[(*JOINT_TABLES,)], Field(discriminator="kind")]


class CouplingTable(Table):
    """Keys of every coupling."""

    joints: list[Name] = Field(min_length=2, max_length=2, description="names of two joints")
    coordinates: list[JointCoordinate] | None = Field(
        default=None,
        min_length=2,
        max_length=2,
        description="of these joints; absent: the only rotation or displacement that each has",
    )
    kind: str


def _coupling_table(coupling: Coupling) -> type[CouplingTable]:
    fields = {key.name: field_of(key) for key in coupling.keys}
    return table_of(CouplingTable, "couplings", coupling.kind, f"{coupling.meaning}.", fields)


COUPLING_TABLES: tuple[type[CouplingTable], ...] = tuple(
    _coupling_table(c) for c in COUPLINGS.values()
)
if TYPE_CHECKING:
    CaseCoupling = CouplingTable
else:
    CaseCoupling = Annotated[Union[(*COUPLING_TABLES,)], Field(discriminator="kind")]


class ElementTable(Table):
    """Keys of every element between two places."""

    between: list[str] = Field(
        min_length=2,
        max_length=2,
        description='two places: "BODY.INTERFACE" or "ground.POINT"',
    )
    kind: str


class LoadTable(Table):
    """Keys of every load from outside."""

    at: str = Field(description='"BODY.INTERFACE"')
    direction: Axis = Field(
        description="at the start, global; only the direction counts", json_schema_extra=unit("-")
    )
    frame: Literal["global", "following"] = Field(
        default="global",
        description="the direction is fixed, or rotates with the interface",
    )
    law: LoadLaw = Field(description="magnitude over time, along the direction")
    kind: str


class CoordinateTable(Table):
    """Keys of every force along a coordinate."""

    joint: Name | None = Field(
        default=None, description="the joint whose coordinate it acts along; or `between`"
    )
    coordinate: JointCoordinate | None = Field(
        default=None, description="of the joint; absent: the only one that it has"
    )
    between: list[str] | None = Field(
        default=None,
        min_length=2,
        max_length=2,
        description="in place of `joint`, two places: the coordinate is their distance",
    )
    kind: str

    @model_validator(mode="after")
    def _one_coordinate(self) -> "CoordinateTable":
        if (self.joint is None) == (self.between is None):
            raise ValueError("expected either `joint` or `between`")
        if self.coordinate is not None and self.joint is None:
            raise ValueError("expected `coordinate` with `joint` only")
        return self


ForceTable = ElementTable | LoadTable | CoordinateTable


def _force_table(
    element: ForceElement,
) -> type[ElementTable] | type[LoadTable] | type[CoordinateTable]:
    text = f"{element.meaning}." + (f"\n\n{element.remark}" if element.remark else "")
    if isinstance(element, Load):
        return table_of(LoadTable, "forces", element.kind, text, {})
    assert isinstance(element, Element | CoordinateForce)
    fields = {key.name: field_of(key) for key in element.keys}
    base = ElementTable if isinstance(element, Element) else CoordinateTable
    return table_of(base, "forces", element.kind, text, fields)


FORCE_TABLES: tuple[type[ElementTable] | type[LoadTable] | type[CoordinateTable], ...] = tuple(
    _force_table(element) for element in FORCES.values()
)
if TYPE_CHECKING:
    CaseForce = ForceTable
else:
    CaseForce = Annotated[Union[(*FORCE_TABLES,)], Field(discriminator="kind")]
