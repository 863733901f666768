"""A solid in TOML: every key with type, unit, bounds and one line of meaning.

docs/solid-description.md is generated from here (`make docs`).
"""

from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from ...errors import InputError
from ...package.specification import LinkKind
from ..common import lines
from ..common.material import Material
from ..common.table import Around, Axis, FilePath, Name, Table, Vector, unit

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}


class SolidMesh(Table):
    """`[mesh]`: a CAD file that is meshed with quadratic tetrahedra, or a mesh."""

    file: FilePath = Field(
        description="path, relative to this file: STEP, IGES or BREP; a .geo script; gmsh's .msh "
        "of tetrahedra or hexahedra"
    )
    size: float | None = Field(
        default=None,
        gt=0,
        description="of the cells of a CAD file, smaller at small radii; absent: a twentieth of "
        "the diagonal",
        json_schema_extra=unit("m"),
    )
    accuracy: float | None = Field(
        default=None,
        gt=0,
        lt=1,
        description="the cells of a CAD file become smaller until the estimated error of the "
        "first six frequencies of the free body is below this",
        json_schema_extra=unit("-"),
    )
    unit: Literal["m", "cm", "mm", "in"] | None = Field(
        default=None, description="of length in the file; absent: STEP and IGES files have one"
    )
    parameters: dict[str, float | list[float]] | None = Field(
        default=None, description='values of the DefineConstant entries "Parameters/KEY" of a .geo'
    )


class AxisAbout(Around):
    """`axis_about`: material axis 1 around an axis, right-handed, 2 along it, 3 outwards."""


class SolidRegion(Table):
    """`[regions.NAME]`: material of a volume: a physical volume, or a solid of a CAD file.

    `all` applies to every volume without its own table.
    """

    material: Name = Field(description="name of a material")
    axis: Axis | None = Field(
        default=None, description="axis 1 of an orthotropic material", json_schema_extra=unit("-")
    )
    normal: Axis | None = Field(
        default=None,
        description="axis 3, as far as it is normal to axis 1",
        json_schema_extra=unit("-"),
    )
    axis_about: AxisAbout | None = Field(default=None, description="axes that follow a cylinder")


class Bore(Table):
    """`bore`: the outer faces on a cylinder, of a hole or a pin."""

    radius: float = Field(gt=0, description="of the cylinder", json_schema_extra=unit("m"))
    point: Vector = Field(description="on its axis", json_schema_extra=unit("m"))
    direction: Axis = Field(description="of its axis, of any length", json_schema_extra=unit("-"))
    length: float | None = Field(
        default=None,
        gt=0,
        description="faces within this length along the axis, half of it on both sides of the "
        "point; absent: all on the cylinder",
        json_schema_extra=unit("m"),
    )


class Plane(Table):
    """`plane`: the outer faces in a plane."""

    point: Vector = Field(description="in the plane", json_schema_extra=unit("m"))
    normal: Axis = Field(description="of the plane, of any length", json_schema_extra=unit("-"))


class SolidInterface(Table):
    """`[interfaces.NAME]` of a solid: outer faces, by one of `bore`, `plane` and `at`."""

    bore: Bore | None = Field(default=None, description="faces on a cylinder")
    plane: Plane | None = Field(default=None, description="faces in a plane")
    at: str | None = Field(default=None, description="physical surface of a script or mesh")
    link: LinkKind = Field(
        default="rigid",
        description="rigid: the faces move as a rigid body; average: the interface follows their "
        "mean motion, and its loads are distributed over them by area",
    )
    position: Vector | None = Field(
        default=None,
        description="reference point; absent: the centre of the faces",
        json_schema_extra=unit("m"),
    )
    rotation_deg: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="rotation vector from body to interface axes",
        json_schema_extra=unit("deg"),
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [key for key in ("bore", "plane", "at") if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError(
                f"expected one of bore, plane, at; found {' and '.join(given) or 'none'}"
            )
        return self


class SolidLoad(Table):
    """`[loads.CASE.NAME]`: at an interface, or an acceleration of the whole solid."""

    at: Name | None = Field(default=None, description="name of an interface")
    force: Vector | None = Field(
        default=None, description="at its reference point", json_schema_extra=unit("N")
    )
    moment: Vector | None = Field(
        default=None, description="about its reference point", json_schema_extra=unit("N m")
    )
    gravity: Vector | None = Field(
        default=None,
        description="weight of the solid, without `at`",
        json_schema_extra=unit("m/s2"),
    )

    @model_validator(mode="after")
    def _sense(self) -> Self:
        if (self.at is None) != (self.gravity is not None) or (
            self.at is not None and self.force is None and self.moment is None
        ):
            raise ValueError("expected `at` with `force` or `moment`, or `gravity` alone")
        return self


class SolidFrequencies(Table):
    """`[frequencies]`: of the free solid, and of the held one with `supports`."""

    count: int = Field(default=6, ge=1, le=200, description="how many")
    error: bool = Field(
        default=True,
        description="estimate their errors by a mesh of two thirds of the cell size",
    )


class SolidDescription(Table):
    """The whole file."""

    format: Literal[1] = Field(default=1, description="of the file")
    title: str = Field(default="", description="one line")
    allow: list[str] = Field(default=[], description="codes of warnings that are meant")
    mesh: SolidMesh = Field(description="geometry and cells")
    materials: dict[Name, Material] = Field(min_length=1, description="elastic constants")
    regions: dict[str, SolidRegion] = Field(min_length=1, description="material of each volume")
    interfaces: dict[Name, SolidInterface] = Field(default={}, description="named places")
    supports: list[Name] = Field(
        default=[], description="interfaces that are held, with rigid links"
    )
    loads: dict[Name, dict[Name, SolidLoad]] = Field(default={}, description="load cases")
    frequencies: SolidFrequencies = Field(
        default=SolidFrequencies(), description="natural frequencies"
    )


# In the order of a manual.
SOLID_TABLES: tuple[type[Table], ...] = (
    *(SolidDescription, SolidMesh, SolidRegion, AxisAbout, SolidInterface, Bore, Plane),
    *(SolidLoad, SolidFrequencies),
)


def checked(table: dict[str, Any], file: Path) -> SolidDescription:
    """Return the description. Raises InputError, one line for each wrong key."""
    try:
        return SolidDescription.model_validate(table)
    except ValidationError as error:
        raise InputError("\n".join(lines(error, SolidDescription, str(file)))) from error
