"""A laminated shell in TOML: every key with type, unit, bounds and one line of meaning.

docs/shell-description.md is generated from here (`make docs`).
"""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from ...errors import InputError, nearest
from ...package.shell import elements
from ...package.shell.elements import DRILLINGS, MEMBRANES, PLATES, QUADS, in_words
from ..common import lines, read_toml
from ..common.lay_up import Angle, LayUp, LayUpPly
from ..common.material import Material
from ..common.table import Around, Axis, Name, Pair, Table, Vector, unit
from .loading import Buckling, Frequencies, Link, Load, Probe, Support

Factor = Annotated[float, Field(gt=0)]
Row = Annotated[list[float], Field(min_length=6, max_length=6)]
MOST_REFINED = 6
# Sizes whose products, as E h^3 and squares of forces, are numbers; what is smaller is no rounding.
LARGE, SMALL = 1e30, 1e-100
REFINE = (
    "makes the mesh finer so many times, each time with four cells for one: a script of "
    "meshes/shells gets twice its counts of cells, cells of other meshes are split at the middles "
    "of their straight sides"
)
Matrix = Annotated[list[Row], Field(min_length=6, max_length=6)]
Offset = Literal["mid", "top", "bottom"] | float


class Mesh(Table):
    """`[mesh]`: a surface mesh of three-node triangles and four-node quadrilaterals."""

    file: str = Field(
        description="path, relative to this file: gmsh's .msh, a .geo script, a .py with "
        "build(gmsh, parameters), or any mesh that meshio reads (.inp, .med, .vtu, ...)"
    )
    parameters: dict[str, bool | float | str | list[float]] | None = Field(
        default=None,
        description='.geo: values of its DefineConstant entries "Parameters/KEY"; .py: what '
        "build gets",
    )
    scale: float | None = Field(
        default=None,
        gt=0,
        description="length in m of the file's unit; 1e-3 for mm; absent: 1",
        json_schema_extra=unit("m"),
    )
    element: Literal["triangle", "quadrilateral"] | None = Field(
        default=None,
        description="quadrilateral: pairs of triangles become quadrilaterals, as far as their "
        "angles allow; triangle: a mesh with others is an error; absent: the cells of the mesh",
    )
    refine: int = Field(default=0, ge=0, le=MOST_REFINED, description=REFINE)


class Ply(LayUpPly):
    """One entry of `plies`."""

    angle_deg: Angle = Field(
        default=0.0,
        description="fibre direction from e1 towards e2, right-handed about the normal",
        json_schema_extra=unit("deg"),
    )
    thickness: float = Field(gt=0, description="of the ply", json_schema_extra=unit("m"))


class Laminate(LayUp):
    """`[laminates.NAME]`: plies from BOTTOM to TOP along the normal of the shell.

    Either `plies`, or the short form of one material: `material`, `angles_deg` and
    `ply_thickness`. Both may be repeated and mirrored, in this order: [0/30]3s is
    angles_deg = [0, 30], repeat = 3, symmetric = true.
    """

    plies: list[Ply] | None = Field(
        default=None, min_length=1, description="the plies, bottom one first"
    )
    angles_deg: list[Angle] | None = Field(
        default=None,
        min_length=1,
        description="short form: angle of each ply, bottom one first",
        json_schema_extra=unit("deg"),
    )
    ply_thickness: float | None = Field(
        default=None,
        gt=0,
        description="short form: thickness of each ply",
        json_schema_extra=unit("m"),
    )
    symmetric: bool = Field(
        default=False, description="true: followed by the same plies in reverse order, top one last"
    )
    offset: Offset = Field(
        default="mid",
        description="position of the mesh in the laminate: mid-plane, top or bottom face; a "
        "number: height of the mid-plane above the mesh, along the normal",
        json_schema_extra=unit("m"),
    )
    shear_correction: (
        Literal["energy-1d", "5/6", "energy-2x2"]
        | Annotated[list[Factor], Field(min_length=2, max_length=2)]
    ) = Field(
        default="energy-1d",
        description="of the transverse shear stiffness: from the shear energy of cylindrical "
        "bending, the factor of a homogeneous plate, the full matrix from equilibrium of the "
        "plies, or two given factors",
    )

    @model_validator(mode="after")
    def _thick(self) -> Self:
        if self.plies is None and self.ply_thickness is None:
            raise ValueError("expected `ply_thickness` with `angles_deg`")
        return self


class AxisAbout(Around):
    """`axis_about`: e1 points around an axis, right-handed."""


class Region(Table):
    """`[regions.NAME]`: laminate or material of a physical surface of the mesh.

    `all` applies to every physical surface without its own table.
    """

    laminate: Name | None = Field(default=None, description="name of a laminate")
    material: Name | None = Field(default=None, description="name of a material: one thick ply")
    thickness: float | None = Field(
        default=None, gt=0, description="with `material`", json_schema_extra=unit("m")
    )
    offset: Offset | None = Field(
        default=None,
        description="with `material`, as in a laminate; absent: mid",
        json_schema_extra=unit("m"),
    )
    axis: Axis | None = Field(
        default=None,
        description="reference direction of the plies: e1 is its projection on the shell. Absent: "
        "x, or y where the normal is along x",
        json_schema_extra=unit("-"),
    )
    axis_curve: str | None = Field(
        default=None, description="instead: a physical curve, e1 follows its nearest edge"
    )
    axis_about: AxisAbout | None = Field(default=None, description="instead: around an axis")
    flip: bool = Field(
        default=False,
        description="true: the normal e3 of the shell is opposite to that of the mesh; the "
        "plies start at the other face",
    )

    @model_validator(mode="after")
    def _one_content(self) -> Self:
        if (self.laminate is None) == (self.material is None):
            raise ValueError("expected either `laminate` or `material`")
        if (self.material is None) != (self.thickness is None):
            raise ValueError("expected `thickness` with `material`, and only there")
        if self.offset is not None and self.material is None:
            raise ValueError("expected `offset` with `material` only: a laminate has its own")
        given = [self.axis, self.axis_curve, self.axis_about]
        if sum(value is not None for value in given) > 1:
            raise ValueError("expected one of `axis`, `axis_curve`, `axis_about`")
        return self


if TYPE_CHECKING:
    Plate = str
    Membrane = str
    Drilling = str
    Quad = str
else:
    Plate = Literal[tuple(PLATES)]
    Membrane = Literal[tuple(MEMBRANES)]
    Drilling = Literal[("auto", "none", *DRILLINGS)]
    Quad = Literal[tuple(QUADS)]


class Elements(Table):
    """`[elements]`: type of the elements; the defaults are the most accurate.

    `plate` and `membrane` are those of triangles, `quadrilateral` is the plate of quadrilaterals.
    Their membrane is hybrid, with sides that fit the membrane of the triangles.
    """

    plate: Plate = Field(
        default=elements.PLATE, description=f"bending and transverse shear: {in_words(PLATES)}"
    )
    membrane: Membrane = Field(
        default=elements.MEMBRANE, description=f"stretching: {in_words(MEMBRANES)}"
    )
    beta0: Annotated[float, Field(gt=0)] | Literal["felippa"] = Field(
        default=elements.BETA0, description="opt only: size of its higher-order stiffness"
    )
    drilling: Drilling = Field(
        default=elements.DRILLING,
        description=f"stiffness of the rotation about the normal: {', '.join(DRILLINGS.values())}; "
        "auto: tie for cst, none for the others. none with cst: nodes in a flat surface have five "
        "degrees of freedom",
    )
    drilling_factor: float = Field(
        default=elements.DRILLING_FACTOR, gt=0, description="of the drilling stiffness"
    )
    quadrilateral: Quad | None = Field(
        default=None,
        description=f"bending and transverse shear of quadrilaterals: {in_words(QUADS)}; absent: "
        f"{elements.QUAD}",
    )
    mass_form: Literal["consistent", "lumped"] = Field(
        default="consistent", description="mass matrix"
    )


class Stiffener(Table):
    """`[stiffeners.NAME]`: a beam along edges of the mesh, with the nodes of the mesh.

    Section axes: x1 along the curve in the direction that gmsh gives it, x3 the normal e3 of the
    shell, x2 = x3 x x1.
    """

    at: str = Field(description="physical curve")
    section: str | None = Field(
        default=None,
        description="path of a section description, relative to this file",
    )
    stiffness: Matrix | None = Field(
        default=None,
        description="instead: the section's 6x6 stiffness, extension, shear 2, shear 3, twist, "
        "bending 2, bending 3",
        json_schema_extra=unit("N, N m, N m2"),
    )
    mass: Matrix | None = Field(
        default=None,
        description="with `stiffness`: 6x6 mass per length, same order",
        json_schema_extra=unit("kg/m, kg, kg m"),
    )
    x2_axis: Vector | None = Field(
        default=None,
        description="instead of the normal: direction of x2, made normal to the curve",
        json_schema_extra=unit("-"),
    )
    offset: Pair = Field(
        default=[0.0, 0.0],
        description="position of the section's reference point from the edge, along x2 and x3",
        json_schema_extra=unit("m"),
    )

    @model_validator(mode="after")
    def _one_section(self) -> Self:
        if (self.section is None) == (self.stiffness is None):
            raise ValueError("expected either `section` or `stiffness`")
        if (self.stiffness is None) != (self.mass is None):
            raise ValueError("expected `mass` with `stiffness`, and only there")
        return self


class ShellDescription(Table):
    """The top of a shell description."""

    format: Literal[1] = Field(description="version of this format")
    title: str = Field(description="one line")
    allow: list[Literal["material-units", "size-units"]] = Field(
        default=[],
        description="warnings that are not shown, because unusual materials or sizes are meant",
    )
    mesh: Mesh = Field(description="a surface mesh with physical groups")
    materials: dict[Name, Material] = Field(min_length=1, description="elastic materials")
    laminates: dict[Name, Laminate] = Field(default={}, description="lay-ups by name")
    regions: dict[str, Region] = Field(
        min_length=1, description="laminate or material of each physical surface"
    )
    elements: Elements = Field(default=Elements(), description="which triangle")
    stiffeners: dict[Name, Stiffener] = Field(
        default={}, description="beams along edges of the mesh, by name"
    )
    links: dict[Name, Link] = Field(
        default={}, description="reference points that move with a group, for supports and loads"
    )
    supports: dict[Name, Support] = Field(default={}, description="supports by name")
    loads: dict[Name, dict[Name, Load]] = Field(
        default={}, description="`[loads.CASE.NAME]`: load cases, each the sum of its loads"
    )
    probes: dict[Name, Probe] = Field(default={}, description="values to show for each load case")
    frequencies: Frequencies | None = Field(
        default=None, description="natural frequencies; absent: none"
    )
    buckling: Buckling | None = Field(
        default=None, description="load factors of buckling; absent: none"
    )

    @model_validator(mode="after")
    def _something_to_do(self) -> Self:
        if not self.loads and self.frequencies is None:
            raise ValueError("loads: no result requested; expected `loads`, `frequencies` or both")
        empty = [name for name, case in self.loads.items() if not case]
        if empty:
            raise ValueError(f"loads.{empty[0]}: expected at least one load, [loads.{empty[0]}.X]")
        stress = self.frequencies.prestress if self.frequencies else None
        for key, name in (
            *(("buckling.cases", name) for name in (self.buckling and self.buckling.cases) or ()),
            ("buckling.constant", self.buckling.constant if self.buckling else None),
            ("frequencies.prestress", stress),
        ):
            if name is not None and name not in self.loads:
                raise ValueError(
                    f'{key} = "{name}": no load case [loads.{name}.X]{nearest(name, self.loads)}'
                )
        if self.buckling and not self.loads:
            raise ValueError("buckling without loads: expected at least one [loads.CASE.NAME]")
        if self.loads and not self.supports:
            raise ValueError("loads without supports: expected at least one table [supports.NAME]")
        return self


def describe(file: Path) -> ShellDescription:
    """Read a shell description and check its keys, types and bounds; see `checked`."""
    return checked(read_toml(file, "shell description"), file)


def checked(table: dict[str, Any], file: Path) -> ShellDescription:
    """Check keys, types and bounds of a description.

    Raises
    ------
    InputError
        One line per error: file, key, value, expectation.
    """
    try:
        description = ShellDescription.model_validate(table)
    except ValidationError as error:
        raise InputError("\n".join(lines(error, ShellDescription, str(file)))) from error
    wrong = [f"{file}: {line}" for line in _out_of_range(table, "")]
    if wrong:
        raise InputError("\n".join(wrong))
    return description


def _out_of_range(value: Any, key: str) -> Iterator[str]:
    """One line for each number whose products with others have no digits left."""
    if isinstance(value, dict):
        for name, entry in value.items():
            yield from _out_of_range(entry, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list):
        for row, entry in enumerate(value):
            yield from _out_of_range(entry, f"{key}[{row}]")
    elif isinstance(value, int | float) and value and not SMALL <= abs(value) <= LARGE:
        yield f"{key} = {value:g}: expected 0, or a size of {SMALL:g} to {LARGE:g}"
