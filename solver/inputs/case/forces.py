"""`[forces.NAME]` of a case file: a table for each kind of dynamics/forces, made from its keys."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import Field, create_model

from ...dynamics.forces.contract import Element, ForceElement
from ...dynamics.forces.table import FORCES
from ..common.table import Table, unit
from .keys import GlobalDirection, field_of
from .laws import LoadLaw


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


def _table(element: ForceElement) -> type[ElementTable] | type[LoadTable]:
    fields: dict[str, Any] = {"kind": (Literal[element.kind], ...)}
    title = f'`[forces.NAME]` with kind = "{element.kind}": {element.meaning}.'
    text = f"{title}\n\n{element.remark}" if element.remark else title
    name = f"{element.kind.title().replace('_', '')}Force"
    if not isinstance(element, Element):
        return create_model(name, __base__=LoadTable, __doc__=text, **fields)
    fields |= {key.name: field_of(key) for key in element.keys}
    return create_model(name, __base__=ElementTable, __doc__=text, **fields)


FORCE_TABLES: tuple[type[ElementTable] | type[LoadTable], ...] = tuple(
    _table(element) for element in FORCES.values()
)
if TYPE_CHECKING:
    CaseForce = ElementTable | LoadTable
else:
    CaseForce = Annotated[Union[(*FORCE_TABLES,)], Field(discriminator="kind")]
