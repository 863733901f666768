"""`[forces.NAME]` of a case file: a table for each kind of dynamics/elements/forces, made from its
keys."""

from typing import TYPE_CHECKING, Annotated, Literal, Union

from pydantic import Field, model_validator

from ...dynamics.elements.forces.contract import CoordinateForce, Element, ForceElement, Load
from ...dynamics.elements.forces.table import FORCES
from ..common.table import Name, Table, unit
from .keys import GlobalDirection, field_of, table_of
from .laws import LoadLaw
from .signals import JointCoordinate


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
    direction: GlobalDirection = Field(
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


def _table(element: ForceElement) -> type[ElementTable] | type[LoadTable] | type[CoordinateTable]:
    text = f"{element.meaning}." + (f"\n\n{element.remark}" if element.remark else "")
    if isinstance(element, Load):
        return table_of(LoadTable, "forces", element.kind, text, {})
    assert isinstance(element, Element | CoordinateForce)
    fields = {key.name: field_of(key) for key in element.keys}
    base = ElementTable if isinstance(element, Element) else CoordinateTable
    return table_of(base, "forces", element.kind, text, fields)


FORCE_TABLES: tuple[type[ElementTable] | type[LoadTable] | type[CoordinateTable], ...] = tuple(
    _table(element) for element in FORCES.values()
)
if TYPE_CHECKING:
    CaseForce = ForceTable
else:
    CaseForce = Annotated[Union[(*FORCE_TABLES,)], Field(discriminator="kind")]
