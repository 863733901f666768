"""A cross-section in TOML: every key with type, unit, bounds and one line of meaning.

docs/section-description.md is generated from here (`make docs`).
"""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ..common import validated
from ..common.lay_up import Angle, Content, Laminate
from ..common.material import Material
from ..common.table import Name, Pair, Table, entry, optional
from .mesh_table import Mesh

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


def checked(table: dict[str, Any], file: Path) -> SectionDescription:
    """Check keys, types and bounds of a description. Raises InputError, one line per error."""
    return validated(SectionDescription, table, file)
