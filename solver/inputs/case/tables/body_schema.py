"""Keys of bodies in a case file: of every body, its reduction, rigid, packaged, imported ones."""

from typing import Literal

from pydantic import ConfigDict

from ...common.table import FilePath, Name, Table, Vector, entry, optional
from .modes import Modes


class Reducible(Table):
    """Keys of every body with a modal package: what a run uses of it."""

    rigid: bool = entry(
        "the run takes the body as rigid, with the mass and inertia of its package; deflections, "
        "resultants and stresses are then 0",
        default=False,
    )
    reduced: list[Modes] | None = optional(
        "the modes that the run uses, as in `modes`: vibrations of the package, and static shapes"
        " rebuilt from all its modes; absent: all modes of the package",
        min_length=1,
    )


class PointInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a rigid body."""

    position: Vector = entry("position in the body frame", "m")


class Placed(Table):
    """Keys of every body: initial position and velocity."""

    position: Vector = entry(
        "frame origin at the start, global; joints are closed from this position",
        "m",
        [0.0, 0.0, 0.0],
    )
    rotation_deg: Vector = entry(
        "rotation vector from global to body axes at the start", "deg", [0.0, 0.0, 0.0]
    )
    velocity: Vector | None = optional(
        "of the frame origin at the start, global; absent: follows from the joints", "m/s"
    )
    angular_velocity: Vector | None = optional(
        "of the frame at the start, body axes; absent: follows from the joints with minimum "
        "kinetic energy",
        "rad/s",
    )


class Deformed(Placed):
    """Keys of every flexible body: initial elastic motion."""

    modal_coordinates: dict[str, float] = entry(
        "at the start, by label or number of the mode, which `plymotion info PACKAGE` lists; "
        "joints are closed by the frames. With start = equilibrium, where the search begins",
        default={},
    )
    modal_rates: dict[str, float] = entry(
        "at the start, likewise; of the others see solver.modes_at_start", "1/s", {}
    )


DAMPING = (
    "of every mode of the body by itself; a mode of the mechanism at a lower frequency f, because "
    "the body carries masses, has about damping_ratio * f / f_body (docs/modes.md)"
)


class RigidBody(Placed):
    """`[bodies.NAME]` with kind = "rigid"."""

    kind: Literal["rigid"]
    mass: float = entry("mass", "kg", gt=0)
    centre: Vector = entry("mass centre in the body frame", "m", [0.0, 0.0, 0.0])
    inertia: list[Vector] = entry(
        "3x3 inertia about the mass centre, body axes; symmetric, positive definite",
        "kg m2",
        min_length=3,
        max_length=3,
    )
    interfaces: dict[Name, PointInterface] = entry("named places", default={})


class PackageBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "package": a modal package from a file."""

    kind: Literal["package"]
    package: FilePath = entry("path of the .vtkhdf file, relative to the case file")


class ImportedBody(Reducible, Deformed):
    """`[bodies.NAME]` with kind = "imported": matrices of another code, reduced when it is built.

    Interfaces, reference condition and modes are in the import file (docs/exchange.md).
    """

    model_config = ConfigDict(populate_by_name=True)  # run files have the name of the field

    kind: Literal["imported"]
    file: str = entry("path of the import file (TOML), relative to the case file", alias="import")
