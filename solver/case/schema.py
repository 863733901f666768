"""Every key of a case file: type, unit, bounds and one line of meaning.

docs/case-reference.md is generated from here (`python -m plymotion.solver check --reference`).
"""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from ..input.material import Material
from ..input.table import Name, Table, Vector, unit
from ..section.mesh_table import ShapeMesh, shape_or


class DescribedSection(Table):
    """`[sections.NAME]` with `file`: a section with lay-ups, or on a mesh of its own.

    Its keys: docs/section-description.md.
    """

    file: str = Field(description="path of a section description, relative to the case file")


if TYPE_CHECKING:
    Section = ShapeMesh | DescribedSection
else:
    Section = shape_or(DescribedSection)


class BeamInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a beam: a node where joints, masses and signals attach."""

    at: Literal["start", "end"] | Annotated[float, Field(ge=0, le=1)] = Field(
        description='"start", "end", or fraction of the length; a node is put there'
    )


class PointInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a rigid body."""

    position: Vector = Field(description="place in the body frame", json_schema_extra=unit("m"))


class Reference(Table):
    """`[bodies.NAME.reference]`: how the body frame is tied to the deformed body."""

    kind: Literal["clamped"] = Field(
        default="clamped", description="frame fixed to one node: its position and tangent"
    )
    at: Name = Field(default="root", description="interface that carries the frame")


class ModeChoice(Table):
    """One entry of `modes`: the lowest modes of a kind."""

    kind: Literal["lowest", "bending-xy", "bending-xz", "torsion", "axial"] = Field(
        description="told apart by their share of modal mass: xy bends in the body's x-y plane"
    )
    count: int = Field(ge=1, le=200, description="how many, lowest frequencies first")


class Placed(Table):
    """Keys of every body: where it starts and how it moves then."""

    position: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="frame origin at the start, global; assembly closes the joints from here",
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
        "at least kinetic energy",
        json_schema_extra=unit("rad/s"),
    )


class BeamBody(Placed):
    """`[bodies.NAME]` with kind = "beam": straight along body x, from x = 0."""

    kind: Literal["beam"]
    length: float = Field(gt=0, description="length", json_schema_extra=unit("m"))
    section: Name = Field(description="name of a section")
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
    elements: int = Field(default=16, ge=1, le=2000, description="beam elements along the length")
    theory: Literal["timoshenko", "classical"] = Field(
        default="timoshenko",
        description="strains of the beam: all six, or classical without shear (nearer to a solid "
        "for vibrating wide strips with bending-twist coupling)",
    )
    mass_form: Literal["consistent", "lumped"] = Field(
        default="consistent", description="inertia from consistent mass, or lumped (the paper)"
    )
    reference: Reference = Field(default=Reference(), description="reference condition")
    modes: list[ModeChoice] = Field(min_length=1, description="which modes the solver gets")
    damping_ratio: float = Field(
        default=0.0, ge=0, lt=1, description="of every mode", json_schema_extra=unit("-")
    )
    interfaces: dict[Name, BeamInterface] = Field(
        min_length=1, description="named places; one must carry the reference condition"
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


class PackageBody(Placed):
    """`[bodies.NAME]` with kind = "package": a modal package from elsewhere."""

    kind: Literal["package"]
    package: str = Field(description="path of the .vtkhdf file, relative to the case file")


Body = Annotated[BeamBody | RigidBody | PackageBody, Field(discriminator="kind")]


class GroundPoint(Table):
    """`[ground.NAME]`: a point of the ground, used as "ground.NAME"."""

    position: Vector = Field(description="global", json_schema_extra=unit("m"))


class Drive(Table):
    """`[joints.NAME.drive]`: prescribed rotation about the joint axis; `speed` or `polynomial`."""

    speed: float | None = Field(
        default=None, description="constant angular velocity", json_schema_extra=unit("rad/s")
    )
    angle: float = Field(
        default=0.0,
        description="angle at t = 0 of a constant speed, from the starting position",
        json_schema_extra=unit("rad"),
    )
    polynomial: list[float] | None = Field(
        default=None,
        min_length=1,
        max_length=8,
        description="c0, c1, ... of angle = c0 + c1 t + c2 t^2 + ..., from the starting position",
        json_schema_extra=unit("rad, rad/s, ..."),
    )

    @model_validator(mode="after")
    def _one_law(self) -> "Drive":
        if (self.speed is None) == (self.polynomial is None):
            raise ValueError("expected either `speed` or `polynomial`")
        return self


class RevoluteJoint(Table):
    """`[joints.NAME]` with kind = "revolute": a hinge."""

    kind: Literal["revolute"]
    between: list[str] = Field(
        min_length=2,
        max_length=2,
        description='two places: "BODY.INTERFACE" or "ground.POINT"; angles count from the first',
    )
    axis: Vector = Field(
        default=[0.0, 0.0, 1.0],
        description="hinge axis at the start, global",
        json_schema_extra=unit("-"),
    )
    drive: Drive | None = Field(default=None, description="prescribed rotation")


class FixedJoint(Table):
    """`[joints.NAME]` with kind = "fixed": no relative motion."""

    kind: Literal["fixed"]
    between: list[str] = Field(min_length=2, max_length=2, description="two places")


Joint = Annotated[RevoluteJoint | FixedJoint, Field(discriminator="kind")]


class PointMass(Table):
    """`[masses.NAME]`: a mass point carried by a body."""

    mass: float = Field(gt=0, description="mass", json_schema_extra=unit("kg"))
    at: str = Field(description='"BODY.INTERFACE"')


class Signal(Table):
    """`[signals.NAME]`: one number along the run."""

    kind: Literal["position", "velocity", "deflection", "rotation"] = Field(
        description="position [m] and velocity [m/s] are global; deflection [m] and elastic "
        "rotation [rad] are relative to the body frame, in its axes"
    )
    at: str = Field(description='"BODY.INTERFACE"')
    component: Literal["x", "y", "z"] = Field(description="axis")
    divide_by: float | None = Field(
        default=None, gt=0, description="makes the signal dimensionless (m for a deflection)"
    )
    description: str = Field(default="", description="words for figures and tables")


class Solver(Table):
    """`[solver]`: time span, integrator, constraint treatment."""

    t_end: float = Field(gt=0, description="end of the run", json_schema_extra=unit("s"))
    output_step: float = Field(
        gt=0, description="interval of the results", json_schema_extra=unit("s")
    )
    integrator: Literal["gear", "rk8", "rk5"] = Field(
        default="gear",
        description="gear: variable-order BDF (the paper); rk8, rk5: explicit Runge-Kutta",
    )
    rtol: float = Field(default=1e-6, gt=0, le=0.1, description="relative tolerance of a step")
    atol_position: float = Field(
        default=1e-8, gt=0, description="absolute tolerance of positions and modal coordinates"
    )
    atol_velocity: float = Field(
        default=1e-6, gt=0, description="absolute tolerance of velocities and modal rates"
    )
    max_order: int = Field(
        default=5,
        ge=1,
        le=5,
        description="cap of the order of gear; 2 is stable on any oscillation",
    )
    max_step: float | None = Field(
        default=None, gt=0, description="largest step", json_schema_extra=unit("s")
    )
    alpha: float = Field(
        default=5.0,
        ge=0,
        description="Baumgarte's velocity feedback",
        json_schema_extra=unit("1/s"),
    )
    beta: float = Field(
        default=5.0,
        ge=0,
        description="Baumgarte's position feedback",
        json_schema_extra=unit("1/s"),
    )
    on_invalid: Literal["stop", "warn"] = Field(
        default="stop",
        description="when a linear body stops being valid: end the run there, or go on",
    )


class Mechanism(Table):
    """What one run computes; a variant may change any of these keys."""

    gravity: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="acceleration of free fall, global",
        json_schema_extra=unit("m/s2"),
    )
    materials: dict[Name, Material] = Field(default={}, description="elastic materials")
    sections: dict[Name, Section] = Field(default={}, description="beam cross-sections")
    bodies: dict[Name, Body] = Field(min_length=1, description="moving bodies")
    ground: dict[Name, GroundPoint] = Field(default={}, description="points of the ground")
    joints: dict[Name, Joint] = Field(default={}, description="constraints")
    masses: dict[Name, PointMass] = Field(default={}, description="point masses")
    signals: dict[Name, Signal] = Field(default={}, description="what is measured")
    solver: Solver = Field(description="time integration")


class Run(Table):
    """`[runs.NAME]`: one computation: the case with some variants applied in order."""

    title: str = Field(default="", description="words for figures and tables")
    variants: list[Name] = Field(default=[], description="names of variants, applied in order")


class Figure(Table):
    """`[figures.NAME]`: one signal of several runs in one picture."""

    title: str = Field(description="title of the picture")
    signal: Name = Field(description="name of a signal")
    runs: list[Name] = Field(min_length=1, description="names of runs")


class CaseFile(Table):
    """The top of a case file, beside the keys of the mechanism."""

    format: Literal[1] = Field(description="version of this format")
    title: str = Field(description="one line")
    variants: dict[Name, dict[str, Any]] = Field(
        default={}, description="partial cases: tables that are merged over the case"
    )
    coarse: dict[str, Any] = Field(
        default={}, description="a variant for quick checks (`make CASE COARSE=1`)"
    )
    runs: dict[Name, Run] = Field(min_length=1, description="what is computed")
    figures: dict[Name, Figure] = Field(default={}, description="pictures that compare runs")
