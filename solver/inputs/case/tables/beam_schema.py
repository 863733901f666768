"""Keys of beams in a case file."""

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo, model_validator

from ....math.definite import is_positive_definite
from ....package.specification import MassForm, Theory
from ...common.table import FilePath, Name, Pair, Table, Vector, entry, optional, usable_path
from .beam_table import with_beam_table
from .body_schema import Flexible
from .columns import FOLDER, RESOLVED
from .modes import Modes

SYMMETRY = 1e-6  # of sqrt(A_ii A_jj): matrices may be given to six digits
Rows = list[list[float]]


def _symmetric(rows: Rows) -> Rows:
    """Return a symmetric 6x6; raises ValueError for another one."""
    if [len(row) for row in rows] != [6] * 6:
        raise ValueError("expected six rows of six numbers")
    matrix = np.array(rows)
    size = np.sqrt(np.abs(np.diagonal(matrix)))
    gap = np.abs(matrix - matrix.T) - SYMMETRY * np.outer(size, size)
    if gap.max() > 0.0:
        i, j = (int(k) for k in np.unravel_index(np.argmax(gap), gap.shape))
        raise ValueError(
            f"expected a symmetric matrix, found {matrix[i, j]:g} in row {i + 1}, column {j + 1} "
            f"and {matrix[j, i]:g} in row {j + 1}, column {i + 1}"
        )
    even: Rows = (0.5 * (matrix + matrix.T)).tolist()
    return even


def _definite(rows: Rows) -> Rows:
    if not is_positive_definite(np.array(rows)):
        raise ValueError("expected a positive definite matrix")
    return rows


Symmetric = Annotated[Rows, AfterValidator(_symmetric)]
Stiffness = Annotated[Symmetric, AfterValidator(_definite)]


class BeamInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a beam: a node where joints, masses and signals attach."""

    at: Literal["start", "end"] | Annotated[float, Field(ge=0, le=1)] = entry(
        '"start", "end", or fraction of the length; the mesh gets a node there'
    )


class BeamLine(Table):
    """`line` of a beam: a circular arc, a spline through points, or given nodes.

    An arc has the given `length` and begins along body x. A spline and nodes have a length.
    """

    arc_deg: float | None = optional("angle of an arc: the tangent turns by it about `axis`", "deg")
    axis: Vector = entry("axis of an arc in the body frame, normal to x", "-", [0.0, 0.0, 1.0])
    points: list[Vector] | None = optional(
        "of a cubic spline, in the body frame", "m", min_length=2
    )
    nodes: list[Vector] | None = optional(
        "of straight elements, in the body frame; interfaces and stations take the nearest",
        "m",
        min_length=2,
    )
    x2_axes: list[Vector] | None = optional(
        "with nodes: direction of the section's x2 in each element; its part normal to the "
        "element counts",
        "-",
        min_length=1,
    )

    @model_validator(mode="after")
    def _one_of_three(self) -> "BeamLine":
        given = [k for k in ("arc_deg", "points", "nodes") if getattr(self, k) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            raise ValueError(f"expected one of arc_deg, points and nodes, found {found}")
        if (self.nodes is None) != (self.x2_axes is None):
            raise ValueError("expected nodes and x2_axes together")
        return self


class BeamStation(Table):
    """One entry of `stations` of a beam: another section along it, or its matrices."""

    at: float = entry("fraction of the length")
    section: Name | None = optional("name of a section; absent: `stiffness` and `mass`")
    stiffness: Stiffness | None = optional(
        "6x6 of a section of your own (docs/conventions.md), about the line", "N, N m, N m2"
    )
    mass: Symmetric | None = optional(
        "6x6 per length, of velocities along and rates about the section axes", "kg/m, kg, kg m"
    )
    trapeze: list[float] = entry(
        "with them: strains of a section twisted by 1 rad/m, times -2; the tension of a spinning "
        "beam stiffens torsion by them",
        "m2, m",
        [0.0] * 6,
        min_length=6,
        max_length=6,
    )
    material: Name | None = optional("absent: that of the body")
    ply_angle_deg: float | None = optional("absent: that of the body", "deg", ge=-90, le=90)

    @model_validator(mode="after")
    def _section_or_matrices(self) -> "BeamStation":
        given = [key for key in ("stiffness", "mass") if getattr(self, key) is not None]
        if len(given) != (2 if self.section is None else 0):
            raise ValueError("expected either `section` or `stiffness` and `mass`")
        return self


class BeamBody(Flexible):
    """`[bodies.NAME]` with kind = "beam": from the origin along body x, or along `line`."""

    kind: Literal["beam"]
    length: float | None = optional(
        "length along the beam; required, except for a line of points or nodes, which has a length",
        "m",
        gt=0,
    )
    line: BeamLine | None = optional(
        "curved reference line: an arc, a spline through points, or given nodes; absent: straight"
        " along x"
    )
    twist_deg: list[Pair] = entry(
        "pairs of a fraction of the length and the rotation of the section there about the line; "
        "linear between them",
        "deg",
        [],
    )
    table: FilePath | None = optional(
        "instead of length, line, twist_deg, section and stations: a CSV file with places, twist,"
        " 6x6 stiffness and mass along the beam (docs/blade.md), relative to the case file; "
        "`elements` then has a default of two between stations"
    )
    section: Name | None = optional(
        "name of a section; with `stations`, of the one at the start; required without `table`"
    )
    stations: list[BeamStation] = entry(
        "other sections along the beam; stiffness and mass are linear between them", default=[]
    )
    segments: int = entry(
        "divides the beam into so many equal bodies joined to each other, for large elastic "
        "rotations (docs/stiffening.md); `modes` are those of each",
        default=1,
        ge=1,
        le=500,
    )
    material: Name | None = optional(
        "name of a material; required by a shape, absent with a described section"
    )
    ply_angle_deg: float | None = optional(
        "fibre direction from x1 towards x2 about the outward normal x3, in solid shapes; absent:"
        " 0",
        "deg",
        ge=-90,
        le=90,
    )
    x2_axis: Vector = entry(
        "direction of the section's x2 (width) in the body frame; normal to x", "-", [0.0, 1.0, 0.0]
    )
    elements: int = entry(
        "beam elements along the length, of all segments", default=16, ge=1, le=2000
    )
    theory: Theory = entry(
        "strains of the beam: all six, or classical without shear (closer to a solid for "
        "vibrating wide strips with bending-twist coupling)",
        default="timoshenko",
    )
    part_of: Name | None = optional(
        "of a segment, written by `check`: the body that it is a part of"
    )
    mass_form: MassForm = entry(
        "inertia from consistent mass, or lumped (the paper)", default="consistent"
    )
    modes: list[Modes] = entry(
        "which modes the solver gets, at least one; of segments, those beside the static shapes "
        "of their ends",
        default=[],
    )
    interfaces: dict[Name, BeamInterface] = entry(
        "named places; some carry the reference condition", min_length=1
    )

    @model_validator(mode="before")
    @classmethod
    def _from_table(cls, data: Any, info: ValidationInfo) -> Any:
        context = info.context or {}
        if not isinstance(data, dict) or not isinstance(data.get("table"), str):
            return data
        if context.get(RESOLVED) or (FOLDER not in context and "stations" in data):
            return data
        usable_path(data["table"])
        return with_beam_table(data, Path(context.get(FOLDER, ".")))
