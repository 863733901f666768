"""Keys of solids in a case file."""

from typing import Literal

from pydantic import Field

from ...common.table import FilePath, Name, unit
from ...solid.description import SolidInterface
from .body_schema import DAMPING, Deformed, Reducible
from .modes import Modes, Reference


class SolidBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "solid": a part from CAD, its axes those of the file.

    Geometry, materials and regions come from the description; its own interfaces, supports, loads
    and frequencies are ignored.
    """

    kind: Literal["solid"]
    solid: FilePath = Field(
        description="path of a solid description (docs/solids.md), relative to the case file"
    )
    size: float | None = Field(
        default=None,
        gt=0,
        description="of the cells, over that of the description",
        json_schema_extra=unit("m"),
    )
    reference: Reference = Field(default=Reference(), description="reference condition")
    modes: list[Modes] = Field(min_length=1, description="which modes the solver gets")
    damping_ratio: float = Field(
        default=0.0, ge=0, lt=1, description=DAMPING, json_schema_extra=unit("-")
    )
    interfaces: dict[Name, SolidInterface] = Field(
        min_length=1, description="named places; some carry the reference condition"
    )
    second_order: bool = Field(
        default=False,
        description="second-order displacements of the modes, which geometric stiffening needs "
        "(docs/stiffening.md)",
    )
