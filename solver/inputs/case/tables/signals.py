"""`[signals.NAME]` of a case file: one number along the run."""

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from ....dynamics.elements.joints.table import COORDINATES
from ....strength import CRITERIA
from ...common.table import Name, Pair, Table, Vector, unit

RUN = (
    "name of another run, whose values at the same times are subtracted; in a sweep with the same "
    "changes. NaN after that run has ended"
)


class Measured(Table):
    """Keys of every signal."""

    divide_by: float | None = Field(
        default=None, gt=0, description="makes the signal dimensionless (in its unit)"
    )
    description: str = Field(default="", description="words for figures and tables")


class DifferenceSignal(Measured):
    """`[signals.NAME]` with kind = "difference": a signal minus another, or minus another run."""

    kind: Literal["difference"]
    of: Name = Field(description="name of a signal")
    minus: Name | None = Field(
        default=None, description="name of the signal that is subtracted; absent: `of`"
    )
    run: Name | None = Field(default=None, description=RUN)

    @model_validator(mode="after")
    def _of_two(self) -> Self:
        if self.minus is None and self.run is None:
            raise ValueError("expected `minus`, `run` or both")
        return self


class NormSignal(Measured):
    """`[signals.NAME]` with kind = "norm": square root of the sum of squares of signals."""

    kind: Literal["norm"]
    of: list[Name] = Field(min_length=1, description="names of signals of one unit")
    run: Name | None = Field(default=None, description=f"of their differences to it: {RUN}")


Component = Literal["x", "y", "z", "magnitude"]
COORDINATE_NAMES = tuple(sorted(COORDINATES))
if TYPE_CHECKING:
    JointCoordinate = str
    CriterionName = str
else:
    JointCoordinate = Literal[COORDINATE_NAMES]
    CriterionName = Literal[tuple(CRITERIA)]


class SegmentFrame(Table):
    """`frame` of a deflection or rotation of a body in segments, written by `check`."""

    places: list[str] = Field(description="interfaces that carry the frame: one, or two of a chord")
    chord: Vector | None = Field(
        description="from the first of two to the second at rest, body axes",
        json_schema_extra=unit("m"),
    )
    rest: Vector = Field(
        description="from the first to the place of the signal at rest, body axes",
        json_schema_extra=unit("m"),
    )
    rotation_deg: Vector = Field(
        description="rotation vector from global to body axes at the start",
        json_schema_extra=unit("deg"),
    )


class PointSignal(Measured):
    """`[signals.NAME]` of a place: how it moves."""

    kind: Literal[
        "position",
        "velocity",
        "acceleration",
        "angular_velocity",
        "orientation",
        "deflection",
        "rotation",
    ] = Field(
        description="position [m], velocity, acceleration, angular_velocity are global; "
        "orientation [rad] is the rotation vector of the interface since the given starting "
        "position, global, without jumps; deflection [m] and elastic rotation [rad] are relative "
        "to the body frame, in its axes"
    )
    at: str = Field(description='"BODY.INTERFACE"')
    seen_from: str | None = Field(
        default=None,
        description="for a deflection: another interface of the body, whose axes (parallel to the "
        "body axes at rest) are the reference; absent: the body frame. Deflections relative to the "
        "body frame depend on the frame, this one does not",
    )
    frame: SegmentFrame | None = Field(
        default=None, description="of a body in segments, written by `check`; not for users"
    )
    component: Component = Field(description="axis")

    @model_validator(mode="after")
    def _same_body(self) -> "PointSignal":
        if self.seen_from is None:
            return self
        if self.kind != "deflection":
            raise ValueError(f"expected `seen_from` with kind deflection only, found {self.kind}")
        if self.seen_from.split(".")[0] != self.at.split(".")[0]:
            raise ValueError(
                f'seen_from = "{self.seen_from}": expected an interface of the body of {self.at}'
            )
        return self


class JointSignal(Measured):
    """`[signals.NAME]` with kind = "joint": the coordinate of a joint."""

    kind: Literal["joint"]
    joint: Name = Field(description="name of a joint")
    coordinate: JointCoordinate = Field(
        description="; ".join(dict.fromkeys(COORDINATES[name].meaning for name in COORDINATE_NAMES))
        + ". All from the given starting position"
    )


class ReactionSignal(Measured):
    """`[signals.NAME]` with kind = "reaction": force or moment of a joint on a body

    With the forces and moments of its drives.
    """

    kind: Literal["reaction"]
    joint: Name = Field(description="name of a joint")
    quantity: Literal["force", "moment"] = Field(
        description="force [N]; moment [N m] about the place"
    )
    component: Component = Field(description="axis")
    side: Literal[1, 2] = Field(default=2, description="on the first or second place of `between`")
    axes: Literal["global", "joint"] = Field(
        default="global", description="joint: those of the first place, z the joint's `axis`"
    )


class ForceSignal(Measured):
    """`[signals.NAME]` with kind = "force": size of a force along a coordinate, or of a coupling.

    Positive where it pushes the coordinate to larger values; of a coupling the first coordinate.
    """

    kind: Literal["force"]
    of: Name = Field(
        description="name of a force along a coordinate (controller, friction, limit_stop, ...) "
        "or of a coupling [N, of a rotation N m]"
    )


class SectionSignal(Measured):
    """A signal of a section of a beam."""

    method: Literal["auto", "modes", "equilibrium"] = Field(
        default="auto",
        description="how resultants are computed; modes: from the modal coordinates; equilibrium: "
        "from loads, joints and inertia of the part beyond the section, for straight beams "
        "without twist; auto: equilibrium for such beams in segments, else modes",
    )


class ResultantSignal(SectionSignal):
    """`[signals.NAME]` with kind = "resultant": force or moment in a beam's section.

    On the face whose normal is the body's +x, in section axes; by modes, linear between the
    stations of the package.
    """

    kind: Literal["resultant"]
    body: Name = Field(description="name of a flexible body")
    x: float = Field(description="place along the body", json_schema_extra=unit("m"))
    component: Literal["F1", "F2", "F3", "M1", "M2", "M3"] = Field(
        description="force [N] or moment [N m]"
    )


class PlyStressSignal(SectionSignal):
    """`[signals.NAME]` with kind = "ply_stress": stress in the axes of a ply."""

    kind: Literal["ply_stress"]
    body: Name = Field(description="name of a flexible body")
    x: float = Field(description="place along the body", json_schema_extra=unit("m"))
    region: str | None = Field(
        default=None, description="region of the section; absent: the only one"
    )
    ply: int = Field(default=0, ge=0, description="number of the ply, 0 is the outermost")
    component: Literal["11", "22", "33", "23", "13", "12"] = Field(
        description="1 along the fibre, 3 normal to the ply [Pa]"
    )
    point: Pair | None = Field(
        default=None,
        description="x2, x3: the nearest integration point of the ply; absent: of all its points "
        "the one with the largest magnitude over the run",
        json_schema_extra=unit("m"),
    )


class StrengthSignal(Measured):
    """`[signals.NAME]` with kind = "strength_ratio" or "exposure": how near plies are to failure.

    At each instant, the lowest strength ratio (highest exposure) of all points that the other keys
    leave: without any of them, of the whole body by all criteria.
    """

    kind: Literal["strength_ratio", "exposure"] = Field(
        description="strength ratio R: factor on all stresses at which a ply fails, infinite "
        "without stress; exposure: 1 / R"
    )
    body: Name = Field(description="name of a flexible body whose materials have strengths")
    x: float | None = Field(
        default=None,
        description="place along a beam; absent: all stations",
        json_schema_extra=unit("m"),
    )
    region: str | None = Field(
        default=None, description="region of the section, or laminate of a shell; absent: all"
    )
    ply: int | None = Field(
        default=None,
        ge=0,
        description="number of the ply, 0 is the outermost, of a shell the bottom; absent: all",
    )
    criterion: CriterionName | None = Field(
        default=None, description="failure criterion; absent: all that apply to the material"
    )
    point: Annotated[list[float], Field(min_length=2, max_length=3)] | None = Field(
        default=None,
        description="of a beam x2, x3: the nearest integration point; of a shell x, y, z in body "
        "axes: the nearest cell; absent: all",
        json_schema_extra=unit("m"),
    )


SIGNAL_TABLES: tuple[type[Table], ...] = (
    PointSignal,
    SegmentFrame,
    JointSignal,
    ReactionSignal,
    ForceSignal,
    ResultantSignal,
    PlyStressSignal,
    StrengthSignal,
    DifferenceSignal,
    NormSignal,
)
Signal = Annotated[
    PointSignal
    | JointSignal
    | ReactionSignal
    | ForceSignal
    | ResultantSignal
    | PlyStressSignal
    | StrengthSignal
    | DifferenceSignal
    | NormSignal,
    Field(discriminator="kind"),
]
