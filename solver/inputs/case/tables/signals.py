"""`[signals.NAME]` of a case file: one number along the run."""

from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from ....dynamics.analysis.motions.table import MOTIONS
from ....dynamics.elements.joints.table import COORDINATES
from ....strength import CRITERIA
from ...common.input_table import Name, Pair, Table, Vector, entry, optional

RUN = (
    "name of another run, whose values at the same times are subtracted; in a sweep with the same "
    "changes. NaN after that run has ended"
)


class Measured(Table):
    """Keys of every signal."""

    divide_by: float | None = optional("makes the signal dimensionless (in its unit)", gt=0)
    keep_unit: bool = entry("`divide_by` is a pure number, such as that of a gear", default=False)
    description: str = entry("words for figures and tables", default="")


class DifferenceSignal(Measured):
    """`[signals.NAME]` with kind = "difference": a signal minus another, or minus another run."""

    kind: Literal["difference"]
    of: Name = entry("name of a signal")
    minus: Name | None = optional("name of the signal that is subtracted; absent: `of`")
    run: Name | None = optional(RUN)

    @model_validator(mode="after")
    def _of_two(self) -> Self:
        if self.minus is None and self.run is None:
            raise ValueError("expected `minus`, `run` or both")
        return self


class NormSignal(Measured):
    """`[signals.NAME]` with kind = "norm": square root of the sum of squares of signals."""

    kind: Literal["norm"]
    of: list[Name] = entry("names of signals of one unit", min_length=1)
    run: Name | None = optional(f"of their differences to it: {RUN}")


Component = Literal["x", "y", "z", "magnitude"]
COORDINATE_NAMES = tuple(sorted(COORDINATES))
if TYPE_CHECKING:
    JointCoordinate = str
    PointKind = Literal["position", "orientation", "deflection", "rotation"]  # and MOTIONS
    OneCoordinate = str
    CriterionName = str
else:
    JointCoordinate = Literal[COORDINATE_NAMES]
    PointKind = Literal[(*MOTIONS, "orientation", "deflection", "rotation")]
    OneCoordinate = JointCoordinate | None
    CriterionName = Literal[tuple(CRITERIA)]


class SegmentFrame(Table):
    """`frame` of a deflection or rotation of a body in segments, written by `check`."""

    places: list[str] = entry("interfaces that carry the frame: one, or two of a chord")
    chord: Vector | None = entry("from the first of two to the second at rest, body axes", "m")
    rest: Vector = entry("from the first to the place of the signal at rest, body axes", "m")
    rotation_deg: Vector = entry("rotation vector from global to body axes at the start", "deg")


class PointSignal(Measured):
    """`[signals.NAME]` of a place: how it moves."""

    kind: PointKind = entry(
        "; ".join(f"{m.kind} [{m.unit}]: {m.meaning}" for m in MOTIONS.values()) + "; orientation "
        "[rad] is "
        "the rotation vector of the interface since the given starting position, global, without "
        "jumps; deflection [m] and elastic rotation [rad] are relative to the body frame, in its "
        "axes"
    )
    at: str = entry('"BODY.INTERFACE"')
    seen_from: str | None = optional(
        "for a deflection: another interface of the body, whose axes (parallel to the body axes "
        "at rest) are the reference; absent: the body frame. Deflections relative to the body "
        "frame depend on the frame, this one does not"
    )
    frame: SegmentFrame | None = optional(
        "of a body in segments, written by `check`; not for users"
    )
    component: Component = entry("axis")

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
    joint: Name = entry("name of a joint")
    coordinate: OneCoordinate = optional(
        "; ".join(dict.fromkeys(COORDINATES[name].meaning for name in COORDINATE_NAMES))
        + ". All from the given starting position. Absent: the only one that the joint has"
    )


class ReactionSignal(Measured):
    """`[signals.NAME]` with kind = "reaction": force or moment of a joint on a body

    With the forces and moments of its drives.
    """

    kind: Literal["reaction"]
    joint: Name = entry("name of a joint")
    quantity: Literal["force", "moment"] = entry("force [N]; moment [N m] about the place")
    component: Component = entry("axis")
    side: Literal[1, 2] = entry("on the first or second place of `between`", default=2)
    axes: Literal["global", "joint"] = entry(
        "joint: those of the first place, z the joint's `axis`", default="global"
    )


class ForceSignal(Measured):
    """`[signals.NAME]` with kind = "force": size of a force along a coordinate, or of a coupling.

    Positive where it pushes the coordinate to larger values; of a coupling the first coordinate.
    """

    kind: Literal["force"]
    of: Name = entry(
        "name of a force along a coordinate (controller, friction, limit_stop, ...) or of a "
        "coupling [N, of a rotation N m]"
    )


class RotorSignal(Measured):
    """`[signals.NAME]` with kind = "rotor": what the air does on the blades of `[rotor]`."""

    kind: Literal["rotor"]
    quantity: Literal["thrust", "moment", "power"] = entry(
        "force along the shaft [N]; moment about it [N m]; moment times the speed of the hub [W]"
    )


class SectionSignal(Measured):
    """A signal of a section of a beam."""

    method: Literal["auto", "modes", "equilibrium"] = entry(
        "how resultants are computed; modes: from the modal coordinates; equilibrium: from loads,"
        " joints and inertia of the part beyond the section, for straight beams without twist; "
        "auto: equilibrium for such beams in segments, else modes",
        default="auto",
    )


class ResultantSignal(SectionSignal):
    """`[signals.NAME]` with kind = "resultant": force or moment in a beam's section.

    On the face whose normal is the body's +x, in section axes; by modes, linear between the
    stations of the package.
    """

    kind: Literal["resultant"]
    body: Name = entry("name of a flexible body")
    x: float = entry("place along the body", "m")
    component: Literal["F1", "F2", "F3", "M1", "M2", "M3"] = entry("force [N] or moment [N m]")


class PlyStressSignal(SectionSignal):
    """`[signals.NAME]` with kind = "ply_stress": stress in the axes of a ply."""

    kind: Literal["ply_stress"]
    body: Name = entry("name of a flexible body")
    x: float = entry("place along the body", "m")
    region: str | None = optional("region of the section; absent: the only one")
    ply: int = entry("number of the ply, 0 is the outermost", default=0, ge=0)
    component: Literal["11", "22", "33", "23", "13", "12"] = entry(
        "1 along the fibre, 3 normal to the ply [Pa]"
    )
    point: Pair | None = optional(
        "x2, x3: the nearest integration point of the ply; absent: of all its points the one with"
        " the largest magnitude over the run",
        "m",
    )


class StrengthSignal(Measured):
    """`[signals.NAME]` with kind = "strength_ratio" or "exposure": how near plies are to failure.

    At each instant, the lowest strength ratio (highest exposure) of all points that the other keys
    leave: without any of them, of the whole body by all criteria.
    """

    kind: Literal["strength_ratio", "exposure"] = entry(
        "strength ratio R: factor on all stresses at which a ply fails, infinite without stress; "
        "exposure: 1 / R"
    )
    body: Name = entry("name of a flexible body whose materials have strengths")
    segments: list[Name] | None = optional(
        "of the body, all of which are meant; written by `check`, not for users"
    )
    x: float | None = optional("place along a beam; absent: all stations", "m")
    region: str | None = optional("region of the section, or laminate of a shell; absent: all")
    ply: int | None = optional(
        "number of the ply, 0 is the outermost, of a shell the bottom; absent: all", ge=0
    )
    criterion: CriterionName | None = optional(
        "failure criterion; absent: all that apply to the material"
    )
    point: Annotated[list[float], Field(min_length=2, max_length=3)] | None = optional(
        "of a beam x2, x3: the nearest integration point; of a shell x, y, z in body axes: the "
        "nearest cell; absent: all",
        "m",
    )


Signal = Annotated[
    PointSignal
    | JointSignal
    | ReactionSignal
    | ForceSignal
    | RotorSignal
    | ResultantSignal
    | PlyStressSignal
    | StrengthSignal
    | DifferenceSignal
    | NormSignal,
    Field(discriminator="kind"),
]
