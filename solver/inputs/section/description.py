"""A cross-section in TOML: every key with type, unit, bounds and one line of meaning.

docs/section-description.md is generated from here (`make docs`).
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model, model_validator

from ..common.input_table import FilePath, Name, Pair, Table, entry, optional, validated
from ..common.materials import Angle, Content, Laminate, Material
from ..common.units import MEANING, Unit, file_units, own_scale
from .shapes.contract import Parameter, Shape, Values
from .shapes.library import SHAPES

FILE = "file"  # the member of a union that is not a shape


class MeshTable(Table):
    """Keys of every `[mesh]`."""

    degree: Literal[1, 2, 3] | None = optional("of the warping in an element; absent: 2")


class ShapeMesh(MeshTable):
    """A shape of the library; its sizes are the fields of the model made from shapes/."""

    shape: str

    @property
    def values(self) -> Values:
        """Sizes as arguments of the shape."""
        return self.model_dump(exclude={"shape", "degree"}, exclude_none=True)


class FileMesh(MeshTable):
    """`[mesh]` with `file`: a mesh of your own."""

    file: FilePath = entry(
        "path, relative to this file: gmsh's .msh or .geo, or any mesh that meshio reads (.inp "
        ".med .bdf .vtu .xdmf ...); its x and y are x2 and x3"
    )
    scale: float | None = optional(
        "length in m of the mesh's unit; 1e-3 for mm; absent: the unit of `units`", "-", gt=0
    )
    parameters: dict[str, float | list[float]] | None = optional(
        '.geo only: numbers or lists for its DefineConstant entries "Parameters/KEY"'
    )
    region_data: str | None = optional(
        "neither .msh nor .geo: cell data with the number of the region, named DATA-VALUE; "
        "absent: named sets and groups, else the only integer cell data"
    )


def _as_list(value: Any) -> Any:
    """Accept one number instead of a list of one."""
    return [value] if isinstance(value, int | float) else value


def _field(parameter: Parameter) -> tuple[Any, Any]:
    """Return type and field of a size."""
    if parameter.text:
        kind: Any = FilePath
    else:
        bounds = Field(gt=parameter.above, ge=parameter.least, le=parameter.most)
        kind = Annotated[float, bounds]
        if parameter.many:
            one_or_more = BeforeValidator(_as_list, json_schema_input_type=list[kind] | kind)
            kind = Annotated[list[kind], one_or_more]
    default = [] if parameter.default == () else parameter.default
    if not parameter.required and default is None:
        kind = kind | None
    default = ... if parameter.required else default
    return kind, entry(parameter.meaning, parameter.unit, default)


def _model(name: str, shape: Shape) -> type[ShapeMesh]:
    fields: dict[str, Any] = {"shape": (Literal[name], ...)}
    fields |= {parameter.key: _field(parameter) for parameter in shape.parameters}
    title = f'shape = "{name}"\n\n{shape.meaning[0].upper()}{shape.meaning[1:]}.'
    return create_model(f"{name} mesh", __base__=ShapeMesh, __doc__=title, **fields)


SHAPE_MESHES: dict[str, type[ShapeMesh]] = {name: _model(name, s) for name, s in SHAPES.items()}


def shape(table: Any) -> Any:
    """Return the name of the model that a table belongs to."""
    if not isinstance(table, dict):
        return getattr(table, "shape", FILE)
    return table.get("shape", FILE if {"file", "description"} & table.keys() else None)


def shape_or(file_table: type[Table]) -> Any:
    """Return the union of all shapes and of a table with the key `file`."""
    members = [Annotated[model, Tag(name)] for name, model in SHAPE_MESHES.items()]
    return Annotated[Union[(*members, Annotated[file_table, Tag(FILE)])], Discriminator(shape)]


if TYPE_CHECKING:
    Mesh = ShapeMesh | FileMesh
else:
    Mesh = shape_or(FileMesh)


Curvature = Annotated[list[float], Field(min_length=3, max_length=3)]


class Direction(Table):
    """`[regions.NAME.direction]`: layer direction, the reference of ply angles; one of three.

    The layer direction y2 lies in the section. Rotated by +90 deg (x1 towards the reader) it is the
    outward normal y3 of the wall. The first ply is on the side of y3.
    """

    vector: Pair | None = optional(
        "y2, of any length; (1, 0) for a top wall, (0, -1) for a right wall", "-"
    )
    curve: str | None = optional(
        "name of a physical curve of the mesh: the outer surface of the region. y2 is its "
        "tangent; the depth of a ply is the distance from it"
    )
    circle: Pair | None = optional(
        "centre of a round wall; the outward direction is away from it", "m"
    )

    @model_validator(mode="after")
    def _one_way(self) -> "Direction":
        if len(self.model_dump(exclude_none=True)) != 1:
            raise ValueError("expected one of `vector`, `curve`, `circle`")
        if self.vector == [0.0, 0.0]:
            raise ValueError("expected a vector of non-zero length")
        return self


class Region(Content):
    """`[regions.NAME]`: material or plies of a wall of the shape, or of a named region of the mesh.

    NAME is a wall of the library shape or a physical surface, element set or group of the mesh;
    `all` applies to every region without its own table.
    """

    angle_deg: Angle | None = optional(
        "with `material`: fibre direction as in a ply; absent: 0", "deg"
    )
    direction: Direction | None = optional(
        "layer direction. Absent: the wall's own in a library shape; x2 for one material along "
        "x1; required for a laminate or an angle in a mesh of your own"
    )

    @model_validator(mode="after")
    def _own_angle(self) -> "Region":
        if self.laminate is not None and self.angle_deg is not None:
            raise ValueError("expected `angle_deg` with `material` only: plies have their own")
        return self


class SectionDescription(Table):
    """The top of a section description."""

    format: Literal[1] = entry("version of this format")
    units: Unit = entry(MEANING, default="m")
    title: str = entry("one line")
    convention: Literal["contour", "cartesian"] | None = optional(
        "sign convention of ply angles; required if one of them is not 0"
    )
    allow: list[
        Literal["nearly-incompressible", "ill-conditioned", "material-units", "size-units"]
    ] = entry(
        "what is computed with a warning instead of an error: linear elements of a material that "
        "locks, equations that appear to be singular; warnings that are not shown, because "
        "unusual materials or sizes are meant",
        default=[],
    )
    initial_curvature: Curvature | None = optional(
        "k1, k2, k3: initial twist and curvature of the reference line, k1 > 0 right-handed; k3 >"
        " 0 has its centre at x2 = 1/k3, k2 > 0 at x3 = -1/k2; absent: prismatic",
        "rad/m",
    )
    taper: float | None = optional(
        "relative change of the size of the section per length; its neglect is estimated", "1/m"
    )
    mesh: Mesh = entry("a shape of the library, or a mesh file")
    materials: dict[Name, Material] = entry("elastic materials", min_length=1)
    laminates: dict[Name, Laminate] = entry("lay-ups by name", default={})
    regions: dict[str, Region] = entry("material or plies of each wall or region", min_length=1)


def checked(table: Mapping[str, Any], file: Path) -> SectionDescription:
    """Check keys, types and bounds of a description. Raises InputError, one line per error."""
    return validated(SectionDescription, own_scale(table), file, **file_units(table))
