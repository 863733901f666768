"""`[couplings.NAME]` of a case file: a table for each kind of dynamics/couplings."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import Field, create_model

from ...dynamics.couplings.contract import Coupling
from ...dynamics.couplings.table import COUPLINGS
from ..common.table import Name, Table
from .keys import field_of
from .signals import JointCoordinate


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


def _table(coupling: Coupling) -> type[CouplingTable]:
    fields: dict[str, Any] = {"kind": (Literal[coupling.kind], ...)}
    fields |= {key.name: field_of(key) for key in coupling.keys}
    title = f'`[couplings.NAME]` with kind = "{coupling.kind}": {coupling.meaning}.'
    name = f"{coupling.kind.title().replace('_', '')}Coupling"
    return create_model(name, __base__=CouplingTable, __doc__=title, **fields)


COUPLING_TABLES: tuple[type[CouplingTable], ...] = tuple(_table(c) for c in COUPLINGS.values())
if TYPE_CHECKING:
    CaseCoupling = CouplingTable
else:
    CaseCoupling = Annotated[Union[(*COUPLING_TABLES,)], Field(discriminator="kind")]
