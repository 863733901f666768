"""Keys of bodies in a case file: of every body, its reduction, rigid, packaged, imported ones."""

from typing import Literal

from pydantic import ConfigDict, Field

from ...common.table import FilePath, Name, Table, Vector, unit
from .modes import Modes


class Reducible(Table):
    """Keys of every body with a modal package: what a run uses of it."""

    rigid: bool = Field(
        default=False,
        description="the run takes the body as rigid, with the mass and inertia of its package; "
        "deflections, resultants and stresses are then 0",
    )
    reduced: list[Modes] | None = Field(
        default=None,
        min_length=1,
        description="the modes that the run uses, as in `modes`: vibrations of the package, and "
        "static shapes rebuilt from all its modes; absent: all modes of the package",
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


DAMPING = (
    "of every mode of the body by itself; a mode of the mechanism at a lower frequency f, because "
    "the body carries masses, has about damping_ratio * f / f_body (docs/modes.md)"
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
