"""Every key of a case file: type, unit, bounds and one line of meaning.

docs/case-reference.md is generated from here (`python -m plymotion.solver check --reference`).
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import ConfigDict, Field, ValidationInfo, model_validator

from ...package.body.specification import MassForm, ShellLinkKind, Theory
from ..common.material import Material
from ..common.table import FilePath, Name, Pair, Table, Vector, Word, unit, usable_path
from ..section.mesh_table import ShapeMesh, shape_or
from .beam_table import with_beam_table
from .couplings import CaseCoupling
from .curves import TablePoints
from .fidelity import Fidelity
from .forces import CaseForce
from .joints import CaseJoint
from .laws import FOLDER, RESOLVED
from .matrices import Stiffness, Symmetric
from .modes import Modes, Reference
from .reduction import Reducible
from .signals import Signal
from .solver import Solver
from .sweeps import Sweep

CHANGES = "other values at dotted keys of the description, in quotes: " + (
    '{ "laminates.wall.angles_deg.1" = 30 }'
)


class DescribedSection(Table):
    """`[sections.NAME]` with `file` or `description`: a section with lay-ups, or its own mesh.

    Keys of a description: docs/section-description.md.
    """

    file: FilePath | None = Field(
        default=None, description="path of a section description, relative to the case file"
    )
    description: dict[str, Any] | None = Field(
        default=None,
        description="instead: the description itself, without format and title; it may use the "
        "materials of the case",
    )
    changes: dict[str, Any] = Field(default={}, description=CHANGES)

    @model_validator(mode="after")
    def _one_of_two(self) -> "DescribedSection":
        if (self.file is None) == (self.description is None):
            raise ValueError("expected either `file` or `description`")
        return self


if TYPE_CHECKING:
    Section = ShapeMesh | DescribedSection
else:
    Section = shape_or(DescribedSection)


class BeamInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a beam: a node where joints, masses and signals attach."""

    at: Literal["start", "end"] | Annotated[float, Field(ge=0, le=1)] = Field(
        description='"start", "end", or fraction of the length; the mesh gets a node there'
    )


class PointInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a rigid body."""

    position: Vector = Field(description="position in the body frame", json_schema_extra=unit("m"))


class Placed(Table):
    """Keys of every body: initial position and velocity."""

    position: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="frame origin at the start, global; joints are closed from this position",
        json_schema_extra=unit("m"),
    )
    rotation_deg: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="rotation vector from global to body axes at the start",
        json_schema_extra=unit("deg"),
    )
    velocity: Vector | None = Field(
        default=None,
        description="of the frame origin at the start, global; absent: follows from the joints",
        json_schema_extra=unit("m/s"),
    )
    angular_velocity: Vector | None = Field(
        default=None,
        description="of the frame at the start, body axes; absent: follows from the joints "
        "with minimum kinetic energy",
        json_schema_extra=unit("rad/s"),
    )


class Deformed(Placed):
    """Keys of every flexible body: initial elastic motion."""

    modal_coordinates: dict[str, float] = Field(
        default={},
        description="at the start, by label or number of the mode, which `plymotion info PACKAGE` "
        "lists; joints are closed by the frames. With start = equilibrium, where the search begins",
    )
    modal_rates: dict[str, float] = Field(
        default={},
        description="at the start, likewise; of the others see solver.modes_at_start",
        json_schema_extra=unit("1/s"),
    )


class BeamLine(Table):
    """`line` of a beam: a circular arc, a spline through points, or given nodes.

    An arc has the given `length` and begins along body x. A spline and nodes have a length.
    """

    arc_deg: float | None = Field(
        default=None,
        description="angle of an arc: the tangent turns by it about `axis`",
        json_schema_extra=unit("deg"),
    )
    axis: Vector = Field(
        default=[0.0, 0.0, 1.0],
        description="axis of an arc in the body frame, normal to x",
        json_schema_extra=unit("-"),
    )
    points: list[Vector] | None = Field(
        default=None,
        min_length=2,
        description="of a cubic spline, in the body frame",
        json_schema_extra=unit("m"),
    )
    nodes: list[Vector] | None = Field(
        default=None,
        min_length=2,
        description="of straight elements, in the body frame; interfaces and stations take the "
        "nearest",
        json_schema_extra=unit("m"),
    )
    x2_axes: list[Vector] | None = Field(
        default=None,
        min_length=1,
        description="with nodes: direction of the section's x2 in each element; its part normal to "
        "the element counts",
        json_schema_extra=unit("-"),
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

    at: float = Field(description="fraction of the length")
    section: Name | None = Field(
        default=None, description="name of a section; absent: `stiffness` and `mass`"
    )
    stiffness: Stiffness | None = Field(
        default=None,
        description="6x6 of a section of your own (docs/conventions.md), about the line",
        json_schema_extra=unit("N, N m, N m2"),
    )
    mass: Symmetric | None = Field(
        default=None,
        description="6x6 per length, of velocities along and rates about the section axes",
        json_schema_extra=unit("kg/m, kg, kg m"),
    )
    trapeze: list[float] = Field(
        default=[0.0] * 6,
        min_length=6,
        max_length=6,
        description="with them: strains of a section twisted by 1 rad/m, times -2; the tension "
        "of a spinning beam stiffens torsion by them",
        json_schema_extra=unit("m2, m"),
    )
    material: Name | None = Field(default=None, description="absent: that of the body")
    ply_angle_deg: float | None = Field(
        default=None,
        ge=-90,
        le=90,
        description="absent: that of the body",
        json_schema_extra=unit("deg"),
    )

    @model_validator(mode="after")
    def _section_or_matrices(self) -> "BeamStation":
        given = [key for key in ("stiffness", "mass") if getattr(self, key) is not None]
        if len(given) != (2 if self.section is None else 0):
            raise ValueError("expected either `section` or `stiffness` and `mass`")
        return self


_DAMPING = (
    "of every mode of the body by itself; a mode of the mechanism at a lower frequency f, because "
    "the body carries masses, has about damping_ratio * f / f_body (docs/modes.md)"
)


class BeamBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "beam": from the origin along body x, or along `line`."""

    kind: Literal["beam"]
    length: float | None = Field(
        default=None,
        gt=0,
        description="length along the beam; required, except for a line of points or nodes, "
        "which has a length",
        json_schema_extra=unit("m"),
    )
    line: BeamLine | None = Field(
        default=None,
        description="curved reference line: an arc, a spline through points, or given nodes; "
        "absent: straight along x",
    )
    twist_deg: list[Pair] = Field(
        default=[],
        description="pairs of a fraction of the length and the rotation of the section there about "
        "the line; linear between them",
        json_schema_extra=unit("deg"),
    )
    table: FilePath | None = Field(
        default=None,
        description="instead of length, line, twist_deg, section and stations: a CSV file with "
        "places, twist, 6x6 stiffness and mass along the beam (docs/blade.md), relative to the "
        "case file; `elements` then has a default of two between stations",
    )
    section: Name | None = Field(
        default=None,
        description="name of a section; with `stations`, of the one at the start; required "
        "without `table`",
    )
    stations: list[BeamStation] = Field(
        default=[],
        description="other sections along the beam; stiffness and mass are linear between them",
    )
    segments: int = Field(
        default=1,
        ge=1,
        le=500,
        description="divides the beam into so many equal bodies joined to each other, for large "
        "elastic rotations (docs/stiffening.md); `modes` are those of each",
    )
    material: Name | None = Field(
        default=None,
        description="name of a material; required by a shape, absent with a described section",
    )
    ply_angle_deg: float | None = Field(
        default=None,
        ge=-90,
        le=90,
        description="fibre direction from x1 towards x2 about the outward normal x3, in solid "
        "shapes; absent: 0",
        json_schema_extra=unit("deg"),
    )
    x2_axis: Vector = Field(
        default=[0.0, 1.0, 0.0],
        description="direction of the section's x2 (width) in the body frame; normal to x",
        json_schema_extra=unit("-"),
    )
    elements: int = Field(
        default=16, ge=1, le=2000, description="beam elements along the length, of all segments"
    )
    theory: Theory = Field(
        default="timoshenko",
        description="strains of the beam: all six, or classical without shear (closer to a solid "
        "for vibrating wide strips with bending-twist coupling)",
    )
    part_of: Name | None = Field(
        default=None, description="of a segment, written by `check`: the body that it is a part of"
    )
    mass_form: MassForm = Field(
        default="consistent", description="inertia from consistent mass, or lumped (the paper)"
    )
    reference: Reference = Field(default=Reference(), description="reference condition")
    modes: list[Modes] = Field(
        default=[],
        description="which modes the solver gets, at least one; of segments, those beside the "
        "static shapes of their ends",
    )
    damping_ratio: float = Field(
        default=0.0, ge=0, lt=1, description=_DAMPING, json_schema_extra=unit("-")
    )
    interfaces: dict[Name, BeamInterface] = Field(
        min_length=1, description="named places; some carry the reference condition"
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


class ShellInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a shell: a physical group of its mesh."""

    at: str = Field(description="physical point, curve or surface of the mesh")
    link: ShellLinkKind = Field(
        default="rigid",
        description="rigid: the group moves as a rigid body; average: the interface follows "
        "the mean motion of the group, and its loads are distributed over the group; section: its "
        "loads are the stresses in the walls of a thin-walled section, for an open end: a curve",
    )
    position: Vector | None = Field(
        default=None,
        description="reference point in the body frame; absent: centre of the group",
        json_schema_extra=unit("m"),
    )
    rotation_deg: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="rotation vector from body to interface axes",
        json_schema_extra=unit("deg"),
    )


class ShellBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "shell": a laminated shell, its axes those of the mesh.

    Mesh, materials, laminates, regions, elements and stiffeners come from the description; its
    links, supports, loads, probes and frequencies are ignored.
    """

    kind: Literal["shell"]
    shell: FilePath = Field(
        description="path of a shell description (docs/shell-description.md), relative to the "
        "case file"
    )
    parameters: dict[str, bool | float | str | list[float]] = Field(
        default={}, description="of the mesh's script, over those of the description"
    )
    changes: dict[str, Any] = Field(default={}, description=CHANGES)
    mass_form: MassForm = Field(
        default="consistent", description="inertia from consistent mass, or lumped (the paper)"
    )
    reference: Reference = Field(default=Reference(), description="reference condition")
    modes: list[Modes] = Field(min_length=1, description="which modes the solver gets")
    damping_ratio: float = Field(
        default=0.0, ge=0, lt=1, description=_DAMPING, json_schema_extra=unit("-")
    )
    interfaces: dict[Name, ShellInterface] = Field(
        min_length=1, description="named places; some carry the reference condition"
    )
    second_order: bool = Field(
        default=False,
        description="second-order displacements of the modes, which geometric stiffening needs "
        "(docs/stiffening.md)",
    )


class RigidBody(Placed):
    """`[bodies.NAME]` with kind = "rigid"."""

    kind: Literal["rigid"]
    mass: float = Field(gt=0, description="mass", json_schema_extra=unit("kg"))
    centre: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="mass centre in the body frame",
        json_schema_extra=unit("m"),
    )
    inertia: list[Vector] = Field(
        min_length=3,
        max_length=3,
        description="3x3 inertia about the mass centre, body axes; symmetric, positive definite",
        json_schema_extra=unit("kg m2"),
    )
    interfaces: dict[Name, PointInterface] = Field(default={}, description="named places")


class PackageBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "package": a modal package from a file."""

    kind: Literal["package"]
    package: FilePath = Field(description="path of the .vtkhdf file, relative to the case file")


class ImportedBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "imported": matrices of another code, reduced when it is built.

    Interfaces, reference condition and modes are in the import file (docs/exchange.md).
    """

    model_config = ConfigDict(populate_by_name=True)  # run files have the name of the field

    kind: Literal["imported"]
    file: str = Field(
        alias="import", description="path of the import file (TOML), relative to the case file"
    )


Body = Annotated[
    BeamBody | ShellBody | RigidBody | PackageBody | ImportedBody, Field(discriminator="kind")
]


class GroundPoint(Table):
    """`[ground.NAME]`: a point of the ground, used as "ground.NAME"."""

    position: Vector = Field(description="global", json_schema_extra=unit("m"))


class PointMass(Table):
    """`[masses.NAME]`: a point mass on a body."""

    mass: float = Field(gt=0, description="mass", json_schema_extra=unit("kg"))
    at: str = Field(description='"BODY.INTERFACE"')


class Mechanism(Table):
    """Keys of one run; a variant may change any of them."""

    gravity: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="acceleration of free fall, global",
        json_schema_extra=unit("m/s2"),
    )
    materials: dict[Name, Material] = Field(default={}, description="elastic materials")
    sections: dict[Name, Section] = Field(default={}, description="beam cross-sections")
    bodies: dict[Name, Body] = Field(min_length=1, description="moving bodies")
    ground: dict[Name, GroundPoint] = Field(default={}, description="points of the ground")
    joints: dict[Name, CaseJoint] = Field(default={}, description="constraints")
    couplings: dict[Name, CaseCoupling] = Field(
        default={}, description="gears, belts, screws: equations between coordinates of joints"
    )
    forces: dict[Name, CaseForce] = Field(
        default={}, description="springs, loads, stops, friction, controllers"
    )
    parameters: dict[Word, float] = Field(
        default={}, description="numbers that expressions read by name"
    )
    tables: dict[Word, TablePoints] = Field(
        default={}, description="curves through points that expressions call by name"
    )
    masses: dict[Name, PointMass] = Field(default={}, description="point masses")
    signals: dict[Name, Signal] = Field(default={}, description="what is measured")
    solver: Solver = Field(description="time integration")
    fidelity: Fidelity | None = Field(
        default=None, description="the accuracy of a run, by which its model is chosen"
    )


class Run(Table):
    """`[runs.NAME]`: one computation: the case with some variants applied in order."""

    title: str = Field(default="", description="words for figures and tables")
    variants: list[Name] = Field(default=[], description="names of variants, applied in order")


class Figure(Table):
    """`[figures.NAME]`: one signal of several runs in one picture."""

    title: str = Field(description="title of the picture")
    signal: Name = Field(description="name of a signal")
    runs: list[Name] = Field(min_length=1, description="names of runs")
    spectrum: bool = Field(
        default=False, description="amplitudes over frequency, with a Hann window, not over time"
    )


class CaseFile(Table):
    """Top-level keys of a case file, in addition to the keys of the mechanism."""

    format: Literal[1] = Field(description="version of this format")
    title: str = Field(description="one line")
    variants: dict[Name, dict[str, Any]] = Field(
        default={}, description="partial cases: tables that are merged into the case"
    )
    coarse: dict[str, Any] = Field(
        default={}, description="a variant for quick checks (`make CASE COARSE=1`), sweeps included"
    )
    runs: dict[Name, Run] = Field(min_length=1, description="what is computed")
    figures: dict[Name, Figure] = Field(default={}, description="pictures that compare runs")
    sweeps: dict[Name, Sweep] = Field(default={}, description="runs varied by numbers")
