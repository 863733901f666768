"""Tables of plies, for cross-sections and shells.

Each table defines from which side plies are listed and where a thickness is optional.
"""

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from .table import Name, Table, entry

Angle = Annotated[float, Field(ge=-90, le=90)]


class LayUpPly(Table):
    """One entry of `plies`."""

    material: Name = entry("name of a material")
    angle_deg: Angle = entry("fibre direction", "deg", 0.0)
    thickness: float | None = entry("of the ply", "m", None, gt=0)
    repeat: int = entry("how many of this ply in a row", default=1, ge=1, le=1000)


class LayUp(Table):
    """`[laminates.NAME]`: either `plies`, or the short form of one material."""

    plies: list[Any] | None = None
    material: Name | None = entry("short form: material of all plies", default=None)
    angles_deg: list[Angle] | None = None
    ply_thickness: float | None = None
    repeat: int = entry("how many times the plies follow", default=1, ge=1, le=1000)
    symmetric: bool = False

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        short = (self.material, self.angles_deg, self.ply_thickness)
        if self.plies is not None and short != (None, None, None):
            raise ValueError("expected either `plies` or the short form, found keys of both")
        if self.plies is None and (self.material is None or self.angles_deg is None):
            raise ValueError("expected `plies`, or `material` with `angles_deg`")
        if len({ply.thickness is None for ply in self.plies or ()}) > 1:
            raise ValueError("expected `thickness` in all plies or in none")
        return self

    def stack(self) -> list[dict[str, Any]]:
        """Return every single ply in the order of the list, in the form for the preprocessor."""
        plies = [
            {"material": p.material, "angle_deg": p.angle_deg, "thickness": p.thickness}
            for p in self.plies or ()
            for _ in range(p.repeat)
        ] or [
            {"material": self.material, "angle_deg": angle, "thickness": self.ply_thickness}
            for angle in self.angles_deg or ()
        ]
        plies *= self.repeat
        if self.symmetric:
            plies += plies[::-1]
        return [{key: v for key, v in ply.items() if v is not None} for ply in plies]
