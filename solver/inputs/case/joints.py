"""`[joints.NAME]` of a case file: all kinds of joints and their drives."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from ..common.table import Table, Vector, unit
from .laws import RotationDrive, TranslationDrive


def _of_some_length(vector: list[float]) -> list[float]:
    if not any(vector):
        raise ValueError("expected a vector of non-zero length")
    return vector


Direction = Annotated[Vector, AfterValidator(_of_some_length)]
Z = [0.0, 0.0, 1.0]


class _Between(Table):
    between: list[str] = Field(
        min_length=2,
        max_length=2,
        description='two places: "BODY.INTERFACE" or "ground.POINT"; motion is that of the second '
        "relative to the first",
    )


class RevoluteJoint(_Between):
    """`[joints.NAME]` with kind = "revolute": a hinge, one rotation."""

    kind: Literal["revolute"]
    axis: Direction = Field(
        default=Z, description="hinge axis at the start, global", json_schema_extra=unit("-")
    )
    drive: RotationDrive | None = Field(default=None, description="prescribed rotation")


class FixedJoint(_Between):
    """`[joints.NAME]` with kind = "fixed": no relative motion."""

    kind: Literal["fixed"]


class SphericalJoint(_Between):
    """`[joints.NAME]` with kind = "spherical": a common point, three rotations."""

    kind: Literal["spherical"]


class UniversalJoint(_Between):
    """`[joints.NAME]` with kind = "universal": a common point and a cross with two axes."""

    kind: Literal["universal"]
    axis: Direction = Field(
        default=Z,
        description="arm of the cross in the first place, at the start, global",
        json_schema_extra=unit("-"),
    )
    axis_2: Direction = Field(
        description="arm in the second place, at a right angle to `axis`",
        json_schema_extra=unit("-"),
    )


class CylindricalJoint(_Between):
    """`[joints.NAME]` with kind = "cylindrical": rotation about an axis, motion along it."""

    kind: Literal["cylindrical"]
    axis: Direction = Field(
        default=Z, description="axis at the start, global", json_schema_extra=unit("-")
    )
    rotation_drive: RotationDrive | None = Field(default=None, description="prescribed rotation")
    translation_drive: TranslationDrive | None = Field(
        default=None, description="prescribed displacement"
    )


class PrismaticJoint(_Between):
    """`[joints.NAME]` with kind = "prismatic": motion along an axis, no rotation."""

    kind: Literal["prismatic"]
    axis: Direction = Field(
        default=Z, description="axis at the start, global", json_schema_extra=unit("-")
    )
    drive: TranslationDrive | None = Field(default=None, description="prescribed displacement")


class PlanarJoint(_Between):
    """`[joints.NAME]` with kind = "planar": motion in a plane, rotation about its normal."""

    kind: Literal["planar"]
    axis: Direction = Field(
        default=Z,
        description="normal of the plane at the start, global",
        json_schema_extra=unit("-"),
    )
    drive: RotationDrive | None = Field(default=None, description="prescribed rotation")


class PointOnLineJoint(_Between):
    """`[joints.NAME]` with kind = "point_on_line": the second place on a line of the first."""

    kind: Literal["point_on_line"]
    axis: Direction = Field(
        default=Z,
        description="line through the first place at the start, global",
        json_schema_extra=unit("-"),
    )
    drive: TranslationDrive | None = Field(default=None, description="prescribed displacement")


class DistanceJoint(_Between):
    """`[joints.NAME]` with kind = "distance": two places a fixed length apart, a massless rod."""

    kind: Literal["distance"]
    length: float | None = Field(
        default=None,
        gt=0,
        description="absent: the distance in the given starting position",
        json_schema_extra=unit("m"),
    )


JOINT_TABLES: tuple[type[Table], ...] = (
    RevoluteJoint,
    FixedJoint,
    SphericalJoint,
    UniversalJoint,
    CylindricalJoint,
    PrismaticJoint,
    PlanarJoint,
    PointOnLineJoint,
    DistanceJoint,
)
Joint = Annotated[
    RevoluteJoint
    | FixedJoint
    | SphericalJoint
    | UniversalJoint
    | CylindricalJoint
    | PrismaticJoint
    | PlanarJoint
    | PointOnLineJoint
    | DistanceJoint,
    Field(discriminator="kind"),
]


def drives(joint: Table) -> dict[str, RotationDrive | TranslationDrive]:
    """Return the drives of a joint by their keys."""
    names = ("drive", "rotation_drive", "translation_drive")
    found = {name: getattr(joint, name, None) for name in names}
    return {name: drive for name, drive in found.items() if drive is not None}
