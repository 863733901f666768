"""Plies and laminates of cross-sections and shells."""

from collections.abc import Iterable
from typing import Annotated, Self

from pydantic import Field, model_validator

from ...errors import unknown
from ...package.specification import PlyTable
from .table import Name, Table, entry, optional

Angle = Annotated[float, Field(ge=-90, le=90)]


class Ply(Table):
    """One entry of `plies`."""

    material: Name = entry("name of a material")
    angle_deg: Angle = entry(
        "fibre direction; of a section from x1 towards the layer direction, sign by `convention`; "
        "of a shell from e1 towards e2, right-handed about the normal",
        "deg",
        0.0,
    )
    thickness: float | None = optional(
        "of a section given for all plies of a laminate, or for none: the wall is divided equally",
        "m",
        gt=0,
    )
    repeat: int = entry("how many of this ply in a row", default=1, ge=1, le=1000)


class Laminate(Table):
    """`[laminates.NAME]`: plies of a section, outermost first; of a shell from BOTTOM to TOP.

    BOTTOM to TOP is along the normal of the shell. Either `plies`, or the short form of one
    material: `material` and `angles_deg`, with `ply_thickness`, which a section may leave out. Both
    may be repeated and mirrored, in this order: [0/30]3s is angles_deg = [0, 30], repeat = 3,
    symmetric = true.
    """

    plies: list[Ply] | None = optional("the plies in their order", min_length=1)
    material: Name | None = optional("short form: material of all plies")
    angles_deg: list[Angle] | None = optional("short form: angle of each ply", "deg", min_length=1)
    ply_thickness: float | None = optional(
        "short form: thickness of each ply; of a section absent: equal shares of the wall",
        "m",
        gt=0,
    )
    repeat: int = entry("how many times the plies follow", default=1, ge=1, le=1000)
    symmetric: bool = entry("true: followed by the same plies in reverse order", default=False)

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

    def stack(self) -> list[PlyTable]:
        """Return every single ply in the order of the list, in the form for the preprocessor."""
        plies = [
            _ply(p.material, p.angle_deg, p.thickness)
            for p in self.plies or ()
            for _ in range(p.repeat)
        ] or [
            _ply(str(self.material), angle, self.ply_thickness) for angle in self.angles_deg or ()
        ]
        plies *= self.repeat
        return plies + plies[::-1] if self.symmetric else plies


def _ply(material: str, angle_deg: float, thickness: float | None) -> PlyTable:
    ply: PlyTable = {"material": material, "angle_deg": angle_deg}
    return ply if thickness is None else {**ply, "thickness": thickness}


class Content(Table):
    """Of what a region is made."""

    laminate: Name | None = optional("name of a laminate")
    material: Name | None = optional("name of a material: one thick ply")

    @model_validator(mode="after")
    def _one_content(self) -> Self:
        if (self.laminate is None) == (self.material is None):
            raise ValueError("expected either `laminate` or `material`")
        return self


def unknown_materials(key: str, names: Iterable[str], known: Iterable[str]) -> list[str]:
    """Return the errors of materials that are named at a key and not described."""
    return [line for name in dict.fromkeys(names) for line in unknown(key, name, "material", known)]
