"""Keys that reduce a flexible body for a run: they need no new package."""

from pydantic import Field

from ..common.table import Table
from .modes import Modes


class Reducible(Table):
    """Keys of every body with a modal package: what a run uses of it."""

    rigid: bool = Field(
        default=False,
        description="the run takes the body as rigid, with the mass and inertia of its package; "
        "deflections, resultants and stresses are then 0",
    )
    reduced: list[Modes] | None = Field(
        default=None,
        min_length=1,
        description="the modes that the run uses, as in `modes`: vibrations of the package, and "
        "static shapes rebuilt from all its modes; absent: all modes of the package",
    )
