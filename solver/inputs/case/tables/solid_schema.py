"""Keys of solids in a case file."""

from typing import Literal

from ...common.table import FilePath, Name, entry, optional
from ...solid.description import SolidInterface
from .body_schema import DAMPING, Deformed, Reducible
from .modes import Modes, Reference


class SolidBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "solid": a part from CAD, its axes those of the file.

    Geometry, materials and regions come from the description; its own interfaces, supports, loads
    and frequencies are ignored.
    """

    kind: Literal["solid"]
    solid: FilePath = entry(
        "path of a solid description (docs/solids.md), relative to the case file"
    )
    size: float | None = optional("of the cells, over that of the description", "m", gt=0)
    reference: Reference = entry("reference condition", default=Reference())
    modes: list[Modes] = entry("which modes the solver gets", min_length=1)
    damping_ratio: float = entry(DAMPING, "-", 0.0, ge=0, lt=1)
    interfaces: dict[Name, SolidInterface] = entry(
        "named places; some carry the reference condition", min_length=1
    )
    second_order: bool = entry(
        "second-order displacements of the modes, which geometric stiffening needs "
        "(docs/stiffening.md)",
        default=False,
    )
