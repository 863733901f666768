"""`[couplings.NAME]` of a case file: a table for each kind of dynamics/elements/couplings."""

from typing import TYPE_CHECKING, Annotated, Union

from pydantic import Field

from ...dynamics.elements.couplings.contract import Coupling
from ...dynamics.elements.couplings.table import COUPLINGS
from ..common.table import Name, Table
from .keys import field_of, table_of
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
    fields = {key.name: field_of(key) for key in coupling.keys}
    return table_of(CouplingTable, "couplings", coupling.kind, f"{coupling.meaning}.", fields)


COUPLING_TABLES: tuple[type[CouplingTable], ...] = tuple(_table(c) for c in COUPLINGS.values())
if TYPE_CHECKING:
    CaseCoupling = CouplingTable
else:
    CaseCoupling = Annotated[Union[(*COUPLING_TABLES,)], Field(discriminator="kind")]
