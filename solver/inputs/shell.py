"""A laminated shell in TOML: every key with type, unit, bounds and one line of meaning.

docs/shell-description.md is generated from here (`make docs`).
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from ..errors import nearest, refuse
from ..package.shell import elements
from ..package.shell.elements import DRILLINGS, MEMBRANES, PLATES, QUADS, in_words
from ..package.specification import ShellLinkKind
from .common.input_table import (
    Around,
    Axis,
    FilePath,
    Name,
    Pair,
    Table,
    Vector,
    entry,
    optional,
    validated,
)
from .common.materials import Content, Laminate, Material, Ply
from .common.units import MEANING, Unit, file_units, own_scale

Freedom = Literal["ux", "uy", "uz", "rx", "ry", "rz"]
FREEDOMS: tuple[Freedom, ...] = ("ux", "uy", "uz", "rx", "ry", "rz")
HELD: dict[str, tuple[Freedom, ...]] = {
    "all": FREEDOMS,
    "symmetry-x": ("ux", "ry", "rz"),
    "symmetry-y": ("uy", "rx", "rz"),
    "symmetry-z": ("uz", "rx", "ry"),
}
ON_CELLS = ("force_per_area", "pressure")
RESULTANTS = ("N11", "N22", "N12", "M11", "M22", "M12", "T1", "T2")
Asked = Literal[
    "ux", "uy", "uz", "rx", "ry", "rz", "N11", "N22", "N12", "M11", "M22", "M12", "T1", "T2"
]


def _as_list(value: object) -> object:
    """Accept one name instead of a list of one."""
    return [value] if isinstance(value, str) else value


LINKS = (
    "rigid: group and point move as a rigid body; average: the point follows the mean motion "
    "of the group, and its loads are distributed over the group; section: its loads are the "
    "stresses in the walls of a thin-walled section, for an open end: a curve"
)


class Link(Table):
    """`[links.NAME]`: a reference point of six degrees of freedom for a group of nodes."""

    at: str | Annotated[list[str], Field(min_length=1)] = entry(
        "physical point, curve or surface, or names of several of one kind"
    )
    kind: ShellLinkKind = entry(LINKS)
    point: Vector | None = optional("the reference point; absent: centre of the group", "m")


class Support(Table):
    """`[supports.NAME]`: degrees of freedom fixed to 0."""

    at: str | Annotated[list[str], Field(min_length=1)] = entry(
        "physical point, curve or surface, names of several of one kind, or a link"
    )
    fixed: (
        Literal["all", "symmetry-x", "symmetry-y", "symmetry-z"]
        | Annotated[list[Freedom], Field(min_length=1)]
    ) = entry(
        "displacements and rotations along and about x, y, z; symmetry-x: the plane normal to x "
        "is a plane of symmetry"
    )
    only: Literal["loads", "modes"] | None = optional(
        "loads: in load cases only, such as the prestress of buckling; modes: in natural modes "
        "and buckling only; absent: in all"
    )

    @property
    def freedoms(self) -> list[str]:
        """The degrees of freedom by name."""
        if isinstance(self.fixed, str):
            return list(HELD[self.fixed])
        return [freedom for freedom in FREEDOMS if freedom in self.fixed]


class Load(Table):
    """`[loads.CASE.NAME]`: one load of a case; one of the values below."""

    at: str | None = optional(
        "physical point, curve or surface, or a link; absent: the whole shell, for gravity, "
        "pressure and force_per_area"
    )
    force: Vector | None = optional(
        "total force, distributed by length of a curve, by area of a surface, or equally by points",
        "N",
    )
    moment: Vector | None = optional("total moment, same distribution", "N m")
    force_per_length: Vector | None = optional("on a curve", "N/m")
    force_per_area: Vector | None = optional("on a surface", "N/m2")
    pressure: float | None = optional("on a surface, along the normal e3 of its region", "Pa")
    sine: Vector | None = optional(
        "with force_per_area or pressure: [a, b, c] multiplies them by sin(pi x/a) sin(pi y/b) "
        "sin(pi z/c); a 0 omits its factor",
        "m",
    )
    gravity: Vector | None = optional("acceleration of gravity, on the whole shell", "m/s2")

    motion: Annotated[dict[Freedom, float], Field(min_length=1)] | None = optional(
        "displacement of components that a support holds, instead of 0: motion = { uz = 1e-3 }",
        "m, rad",
    )

    more_lengths = ("motion.ux", "motion.uy", "motion.uz")

    @model_validator(mode="after")
    def _one_load(self) -> Self:
        given = self.model_dump(exclude_none=True, exclude={"at", "sine"})
        if len(given) != 1:
            raise ValueError(
                "expected one of `force`, `moment`, `force_per_length`, `force_per_area`, "
                f"`pressure`, `gravity`, `motion`, found {', '.join(given) or 'none'}"
            )
        if "gravity" in given and self.at is not None:
            raise ValueError("expected no `at` with `gravity`: it acts on the whole shell")
        if self.at is None and not set(given) & {"gravity", *ON_CELLS}:
            raise ValueError(f"expected `at` with `{next(iter(given))}`")
        if self.sine is not None and not set(given) & set(ON_CELLS):
            raise ValueError("expected `sine` with `force_per_area` or `pressure` only")
        return self


class Probe(Table):
    """`[probes.NAME]`: values to show for each load case."""

    one_of = ("at", "near")

    at: str | None = optional("physical point, curve or surface (mean value), or a link")
    near: Vector | None = optional(
        "instead of `at` a position: the nearest node, or for resultants the nearest cell", "m"
    )
    what: Annotated[
        list[Asked],
        Field(min_length=1),
        BeforeValidator(_as_list, json_schema_input_type=list[Asked] | Asked),
    ] = entry("displacements, rotations, or resultants in laminate axes")


class Frequencies(Table):
    """`[frequencies]`: natural frequencies and modes."""

    count: int = entry("number of modes, from the lowest", default=6, ge=1, le=1000)
    free: bool = entry("true: without the supports; six frequencies are then 0", default=False)
    prestress: str | None = optional(
        "name of a load case: the modes of the shell under its stresses"
    )
    error: bool | None = optional(
        "whether to estimate the errors of the mesh, by a mesh of half the cell size; absent: up "
        "to 4000 unknowns, and with `prestress`"
    )


class Buckling(Table):
    """`[buckling]`: load factors of linear buckling, also with `--buckling`."""

    count: int = entry("of factors of each load case", default=4, ge=1, le=100)
    cases: list[str] | None = optional("load cases that are multiplied; absent: all but `constant`")
    constant: str | None = optional("load case whose stresses are there and are not multiplied")
    in_plane: bool = entry(
        "false: without the work of the prestress on rotations about the normal, as in tables of "
        "plates",
        default=True,
    )
    error: bool = entry(
        "whether to estimate the errors of the mesh, by a mesh of half the cell size", default=True
    )


Factor = Annotated[float, Field(gt=0)]
Row = Annotated[list[float], Field(min_length=6, max_length=6)]
MOST_REFINED = 6
SHAPES = ("box-beam", "curved-beam", "cylinder", "hemisphere", "plate", "twisted-beam")
# Sizes whose products, as E h^3 and squares of forces, are numbers; what is smaller is no rounding.
LARGE, SMALL = 1e30, 1e-100
REFINE = (
    "number of refinements of the mesh, each with four cells in place of one: a script of "
    "meshes/shells gets twice its counts of cells, cells of other meshes are split at the middles "
    "of their straight sides"
)
Matrix = Annotated[list[Row], Field(min_length=6, max_length=6)]
Offset = Literal["mid", "top", "bottom"] | float


class Mesh(Table):
    """`[mesh]`: a surface mesh of three-node triangles and four-node quadrilaterals."""

    one_of = ("file", "shape")

    file: FilePath | None = optional(
        "path, relative to this file: gmsh's .msh, a .geo script, a .py with build(gmsh, "
        "parameters), or any mesh that meshio reads (.inp, .med, .vtu, ...)"
    )
    shape: Literal[SHAPES] | None = optional(  # type: ignore[valid-type]
        "instead: a script of meshes/shells, whose first lines name its sizes and groups: plate "
        "(region plate; curves left, right, bottom, top) has the parameters length and width [m], "
        "n_length and n_width cells"
    )
    parameters: dict[str, bool | float | str | list[float]] | None = optional(
        "sizes of the `shape`; .geo: values of its DefineConstant entries "
        '"Parameters/KEY"; .py: what build gets'
    )
    scale: float | None = optional(
        "length in m of the unit of mesh or script; 1e-3 for mm; absent: the unit of `units`",
        "-",
        gt=0,
    )
    element: Literal["triangle", "quadrilateral"] | None = optional(
        "quadrilateral: pairs of triangles become quadrilaterals, as far as their angles allow; "
        "triangle: a mesh with others is an error; absent: the cells of the mesh"
    )
    refine: int = entry(REFINE, default=0, ge=0, le=MOST_REFINED)


class ShellPly(Ply):
    """One entry of `plies`."""

    thickness: float = entry("of the ply", "m", gt=0)


class ShellLaminate(Laminate):
    """`[laminates.NAME]`: plies from BOTTOM to TOP along the normal of the shell.

    Either `plies`, or the short form of one material: `material`, `angles_deg` or `layup`, and
    `ply_thickness`. Plies and angles may be repeated and mirrored, in this order:
    layup = "[0/30]3s" is angles_deg = [0, 30], repeat = 3, symmetric = true.
    """

    plies: list[ShellPly] | None = optional(  # type: ignore[assignment]
        "the plies, bottom one first", min_length=1
    )
    offset: Offset = entry(
        "position of the mesh in the laminate: mid-plane, top or bottom face; a number: height of"
        " the mid-plane above the mesh, along the normal",
        "m",
        "mid",
    )
    shear_correction: (
        Literal["energy-1d", "5/6", "energy-2x2"]
        | Annotated[list[Factor], Field(min_length=2, max_length=2)]
    ) = entry(
        "of the transverse shear stiffness: from the shear energy of cylindrical bending, the "
        "factor of a homogeneous plate, the full matrix from equilibrium of the plies, or two "
        "given factors",
        default="energy-1d",
    )

    @model_validator(mode="after")
    def _thick(self) -> Self:
        if self.plies is None and self.ply_thickness is None:
            raise ValueError("expected `ply_thickness` with the short form")
        return self


class AxisAbout(Around):
    """`axis_about`: e1 points around an axis, right-handed."""


class Region(Content):
    """`[regions.NAME]`: laminate or material of a physical surface of the mesh.

    `all` applies to every physical surface without its own table.
    """

    thickness: float | None = optional("with `material`", "m", gt=0)
    offset: Offset | None = optional("with `material`, as in a laminate; absent: mid", "m")
    axis: Axis | None = optional(
        "reference direction of the plies: e1 is its projection on the shell; required with "
        "orthotropic materials, or one of the next two. Absent: x, or y where the normal is "
        "along x",
        "-",
    )
    axis_curve: str | None = optional("instead: a physical curve, e1 follows its nearest edge")
    axis_about: AxisAbout | None = optional("instead: around an axis")
    flip: bool = entry(
        "true: the normal e3 of the shell is opposite to that of the mesh; the plies start at the"
        " other face",
        default=False,
    )

    @model_validator(mode="after")
    def _own_thickness(self) -> Self:
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

    plate: Plate = entry(
        f"bending and transverse shear: {in_words(PLATES)}", default=elements.PLATE
    )
    membrane: Membrane = entry(f"stretching: {in_words(MEMBRANES)}", default=elements.MEMBRANE)
    beta0: Annotated[float, Field(gt=0)] | Literal["felippa"] = entry(
        "opt only: size of its higher-order stiffness", default=elements.BETA0
    )
    drilling: Drilling = entry(
        f"stiffness of the rotation about the normal: {', '.join(DRILLINGS.values())}; "
        "auto: tie for cst, none for the others. none with cst: nodes in a flat surface have five "
        "degrees of freedom",
        default=elements.DRILLING,
    )
    drilling_factor: float = entry(
        "of the drilling stiffness", default=elements.DRILLING_FACTOR, gt=0
    )
    quadrilateral: Quad | None = optional(
        f"bending and transverse shear of quadrilaterals: {in_words(QUADS)}; absent: "
        f"{elements.QUAD}"
    )
    mass_form: Literal["consistent", "lumped"] = entry("mass matrix", default="consistent")


class Stiffener(Table):
    """`[stiffeners.NAME]`: a beam along edges of the mesh, with the nodes of the mesh.

    Section axes: x1 along the curve in the direction that gmsh gives it, x3 the normal e3 of the
    shell, x2 = x3 x x1.
    """

    one_of = ("section", "stiffness")

    at: str = entry("physical curve")
    section: str | None = optional("path of a section description, relative to this file")
    stiffness: Matrix | None = optional(
        "instead: the section's 6x6 stiffness, extension, shear 2, shear 3, twist, bending 2, "
        "bending 3",
        "N, N m, N m2",
    )
    mass: Matrix | None = optional(
        "with `stiffness`: 6x6 mass per length, same order", "kg/m, kg, kg m"
    )
    x2_axis: Vector | None = optional(
        "instead of the normal: direction of x2, made normal to the curve", "-"
    )
    offset: Pair = entry(
        "position of the section's reference point from the edge, along x2 and x3", "m", [0.0, 0.0]
    )

    @model_validator(mode="after")
    def _one_section(self) -> Self:
        if (self.stiffness is None) != (self.mass is None):
            raise ValueError("expected `mass` with `stiffness`, and only there")
        return self


class ShellDescription(Table):
    """The top of a shell description."""

    format: Literal[1] = entry("version of this format")
    units: Unit = entry(MEANING, default="m")
    title: str = entry("one line")
    allow: list[Literal["material-units", "size-units"]] = entry(
        "warnings that are not shown, because unusual materials or sizes are meant", default=[]
    )
    mesh: Mesh = entry("a surface mesh with physical groups")
    materials: dict[Name, Material] = entry("elastic materials", min_length=1)
    laminates: dict[Name, ShellLaminate] = entry("lay-ups by name", default={})
    regions: dict[str, Region] = entry(
        "laminate or material of each physical surface", min_length=1
    )
    elements: Elements = entry("which triangle", default=Elements())
    stiffeners: dict[Name, Stiffener] = entry("beams along edges of the mesh, by name", default={})
    links: dict[Name, Link] = entry(
        "reference points that move with a group, for supports and loads", default={}
    )
    supports: dict[Name, Support] = entry("supports by name", default={})
    loads: dict[Name, dict[Name, Load]] = entry(
        "`[loads.CASE.NAME]`: load cases, each the sum of its loads", default={}
    )
    probes: dict[Name, Probe] = entry("values to show for each load case", default={})
    frequencies: Frequencies | None = optional("natural frequencies; absent: none")
    buckling: Buckling | None = optional("load factors of buckling; absent: none")
    bound: Literal["frequency", "buckling", "compliance"] | None = optional(
        "bound of the lowest frequency, or of load factor or work of the one load case, over "
        "all angles of the plies, also with `--bound`; absent: none"
    )
    bound_angles_deg: list[float] | None = optional(
        "with a bound: also the best lay-up of plies at these angles", "deg", min_length=1
    )

    @model_validator(mode="after")
    def _something_to_do(self) -> Self:
        if not self.loads and self.frequencies is None and self.bound is None:
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
        if self.bound in ("buckling", "compliance") and not self.loads:
            raise ValueError(f'bound = "{self.bound}" without loads: expected [loads.CASE.NAME]')
        if self.bound_angles_deg and not self.bound:
            raise ValueError("bound_angles_deg without bound: expected bound, or --bound")
        if self.loads and not self.supports:
            raise ValueError("loads without supports: expected at least one table [supports.NAME]")
        return self


def checked(table: Mapping[str, Any], file: Path) -> ShellDescription:
    """Check keys, types and bounds of a description. Raises InputError, one line per error."""
    description = validated(ShellDescription, own_scale(table), file, **file_units(table))
    wrong = [f"{file}: {line}" for line in _out_of_range(table, "")]
    refuse(wrong)
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
