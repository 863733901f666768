"""A solid in TOML: every key with type, unit, bounds and one line of meaning.

docs/solid-description.md is generated from here (`make docs`).
"""

from typing import Literal, Self

from pydantic import model_validator

from ..package.specification import LinkKind
from .common.input_table import (
    Around,
    Axis,
    FilePath,
    Name,
    Oriented,
    Table,
    Vector,
    entry,
    optional,
)
from .common.materials import Material
from .common.units import MEANING, Unit


class SolidMesh(Table):
    """`[mesh]`: a CAD file that is meshed with quadratic tetrahedra, or a mesh."""

    file: FilePath = entry(
        "path, relative to this file: STEP, IGES or BREP; a .geo script; a mesh of tetrahedra or "
        "hexahedra: gmsh's .msh, MED, or another that meshio reads"
    )
    size: float | None = optional(
        "of the cells of a CAD file, smaller at small radii; absent: a twentieth of the "
        "diagonal, or less if the volume of a thin curved part needs it (docs/solids.md)",
        "m",
        gt=0,
    )
    accuracy: float | None = optional(
        "the cells of a CAD file become smaller until the estimated error of the first six "
        "frequencies of the free body is below this",
        "-",
        gt=0,
        lt=1,
    )
    unit: Unit | None = optional("of length in that file; absent: STEP and IGES files have one")
    parameters: dict[str, float | list[float]] | None = optional(
        'values of the DefineConstant entries "Parameters/KEY" of a .geo'
    )


class AxisAbout(Around):
    """`axis_about`: material axis 1 around an axis, right-handed, 2 along it, 3 outwards."""


class AxisAlong(Table):
    """`axis_along`: material axis 1 along a curve; 3 is `normal`, as far as it is normal to 1.

    1 is the tangent at the nearest point of the curve.
    """

    one_of = ("points", "at")

    points: list[Vector] | None = optional("corners of the curve", "m", min_length=2)
    at: str | None = optional("physical curve of a script or mesh")


class SolidRegion(Table):
    """`[regions.NAME]`: material of a volume: a physical volume, or a solid of a CAD file.

    `all` applies to every volume without its own table.
    """

    material: Name = entry("name of a material")
    axis: Axis | None = optional("axis 1 of an orthotropic material", "-")
    normal: Axis | None = optional(
        "axis 3, as far as it is normal to axis 1, with `axis` or `axis_along`", "-"
    )
    axis_about: AxisAbout | None = optional("axes that follow a cylinder")
    axis_along: AxisAlong | None = optional("axis 1 follows a curve")


class Bore(Table):
    """`bore`: the outer faces on a cylinder, of a hole or a pin."""

    radius: float = entry("of the cylinder", "m", gt=0)
    point: Vector = entry("on its axis", "m")
    direction: Axis = entry("of its axis, of any length", "-")
    length: float | None = optional(
        "faces within this length along the axis, half of it on both sides of the point; absent: "
        "all on the cylinder",
        "m",
        gt=0,
    )


class Plane(Table):
    """`plane`: the outer faces in a plane."""

    point: Vector = entry("in the plane", "m")
    normal: Axis = entry("of the plane, of any length", "-")


class SolidInterface(Oriented):
    """`[interfaces.NAME]` of a solid: outer faces, by one of `bore`, `plane` and `at`."""

    one_of = ("bore", "plane", "at")

    bore: Bore | None = optional("faces on a cylinder")
    plane: Plane | None = optional("faces in a plane")
    at: str | None = optional("physical surface of a script or mesh")
    link: LinkKind = entry(
        "rigid: the faces move as a rigid body; average: the interface follows their mean motion,"
        " and its loads are distributed over them by area",
        default="rigid",
    )


class SolidLoad(Table):
    """`[loads.CASE.NAME]`: at an interface, or an acceleration of the whole solid."""

    at: Name | None = optional("name of an interface")
    force: Vector | None = optional("at its reference point", "N")
    moment: Vector | None = optional("about its reference point", "N m")
    pressure: float | None = optional(
        "on its faces, inwards; it keeps the direction of the undeformed faces", "Pa"
    )
    gravity: Vector | None = optional("weight of the solid, without `at`", "m/s2")

    @model_validator(mode="after")
    def _sense(self) -> Self:
        at_faces = any(x is not None for x in (self.force, self.moment, self.pressure))
        if (self.at is None) == at_faces or at_faces == (self.gravity is not None):
            raise ValueError(
                "expected `at` with `force`, `moment` or `pressure`, or `gravity` alone"
            )
        return self


class SolidFrequencies(Table):
    """`[frequencies]`: of the free solid, and of the held one with `supports`."""

    count: int = entry("how many", default=6, ge=1, le=200)
    error: bool = entry(
        "estimate their errors by displacements of degree 3 on the same mesh", default=True
    )


class SolidDescription(Table):
    """The whole file."""

    format: Literal[1] = entry("of the file", default=1)
    units: Unit = entry(MEANING, default="m")
    title: str = entry("one line", default="")
    allow: list[Literal["material-units", "size-units"]] = entry(
        "warnings that are not shown, because unusual materials or sizes are meant", default=[]
    )
    mesh: SolidMesh = entry("geometry and cells")
    materials: dict[Name, Material] = entry("elastic constants", min_length=1)
    regions: dict[str, SolidRegion] = entry("material of each volume", min_length=1)
    interfaces: dict[Name, SolidInterface] = entry("named places", default={})
    supports: list[Name] = entry("interfaces that are held, with rigid links", default=[])
    loads: dict[Name, dict[Name, SolidLoad]] = entry("load cases", default={})
    frequencies: SolidFrequencies = entry("natural frequencies", default=SolidFrequencies())
