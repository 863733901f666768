"""The table `[mesh]`: a shape of the library with its sizes, or a file."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model

from ..common.table import Table, entry, optional
from .shapes.library import SHAPES, Parameter, Shape

FILE = "file"  # the member of a union that is not a shape


class MeshTable(Table):
    """Keys of every `[mesh]`."""

    degree: Literal[1, 2, 3] | None = optional("of the warping in an element; absent: 2")


class ShapeMesh(MeshTable):
    """A shape of the library; its sizes are the fields of the model made from shapes/."""

    shape: str

    @property
    def values(self) -> dict[str, Any]:
        """Sizes as arguments of the shape."""
        return self.model_dump(exclude={"shape", "degree"}, exclude_none=True)


class FileMesh(MeshTable):
    """`[mesh]` with `file`: a mesh of your own."""

    file: str = entry(
        "path, relative to this file: gmsh's .msh or .geo, or any mesh that meshio reads (.inp "
        ".med .bdf .vtu .xdmf ...); its x and y are x2 and x3"
    )
    scale: float | None = optional(
        "length in m of the file's unit; 1e-3 for mm; absent: 1", "m", gt=0
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
        kind: Any = str
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
