"""`[forces.NAME]` of a case file: springs, dampers, actuators, bushings and loads."""

from typing import Annotated, Literal

from pydantic import Field

from ..common.table import Table, unit
from .joints import GlobalDirection, Z
from .laws import LoadLaw

NONE = [0.0, 0.0, 0.0]
Positive = Annotated[float, Field(ge=0)]
Constants = Annotated[list[Positive], Field(min_length=3, max_length=3)]


class _Element(Table):
    between: list[str] = Field(
        min_length=2,
        max_length=2,
        description='two places: "BODY.INTERFACE" or "ground.POINT"',
    )


class Spring(_Element):
    """`[forces.NAME]` with kind = "spring": spring, damper and actuator between two places."""

    kind: Literal["spring"]
    stiffness: float = Field(default=0.0, ge=0, description="k", json_schema_extra=unit("N/m"))
    damping: float = Field(default=0.0, ge=0, description="c", json_schema_extra=unit("N s/m"))
    length: float | None = Field(
        default=None,
        ge=0,
        description="of the spring without force; absent: the distance in the given starting "
        "position",
        json_schema_extra=unit("m"),
    )
    actuator: LoadLaw | None = Field(
        default=None, description="force [N] that pushes the places apart"
    )


class RotarySpring(_Element):
    """`[forces.NAME]` with kind = "rotary_spring": spring, damper and actuator of a hinge.

    Its moment is discontinuous half a turn away from the rest angle.
    """

    kind: Literal["rotary_spring"]
    axis: GlobalDirection = Field(
        default=Z, description="axis at the start, global", json_schema_extra=unit("-")
    )
    stiffness: float = Field(default=0.0, ge=0, description="k", json_schema_extra=unit("N m/rad"))
    damping: float = Field(default=0.0, ge=0, description="c", json_schema_extra=unit("N m s/rad"))
    angle: float = Field(
        default=0.0,
        description="angle without moment, from the given starting position",
        json_schema_extra=unit("rad"),
    )
    actuator: LoadLaw | None = Field(
        default=None, description="torque [N m] on the second place about the axis"
    )


class Bushing(_Element):
    """`[forces.NAME]` with kind = "bushing": springs and dampers on all six relative motions.

    At rest where the two places coincide with the axes of the given starting position.
    """

    kind: Literal["bushing"]
    axis: GlobalDirection = Field(
        default=Z,
        description="third axis at the start, global; fixed in the first place",
        json_schema_extra=unit("-"),
    )
    axis_1: GlobalDirection | None = Field(
        default=None,
        description="first axis, at a right angle to `axis`; absent: the global axis farthest "
        "from `axis`, made orthogonal",
        json_schema_extra=unit("-"),
    )
    stiffness: Constants = Field(description="along the three axes", json_schema_extra=unit("N/m"))
    rotary_stiffness: Constants = Field(
        default=NONE, description="about the three axes", json_schema_extra=unit("N m/rad")
    )
    damping: Constants = Field(
        default=NONE, description="along the three axes", json_schema_extra=unit("N s/m")
    )
    rotary_damping: Constants = Field(
        default=NONE, description="about the three axes", json_schema_extra=unit("N m s/rad")
    )


class _Load(Table):
    at: str = Field(description='"BODY.INTERFACE"')
    direction: GlobalDirection = Field(
        description="at the start, global; only the direction counts", json_schema_extra=unit("-")
    )
    frame: Literal["global", "following"] = Field(
        default="global",
        description="the direction is fixed, or rotates with the interface",
    )
    law: LoadLaw = Field(description="magnitude over time, along the direction")


class ForceLoad(_Load):
    """`[forces.NAME]` with kind = "force": a force [N] from outside."""

    kind: Literal["force"]


class TorqueLoad(_Load):
    """`[forces.NAME]` with kind = "torque": a torque [N m] from outside."""

    kind: Literal["torque"]


FORCE_TABLES: tuple[type[Table], ...] = (Spring, RotarySpring, Bushing, ForceLoad, TorqueLoad)
Force = Annotated[
    Spring | RotarySpring | Bushing | ForceLoad | TorqueLoad, Field(discriminator="kind")
]
