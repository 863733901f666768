"""Keys of bodies in a case file: of every body; of shells, solids, rigid bodies and packages."""

from typing import Any, Literal

from pydantic import ConfigDict

from ....package.specification import MassForm, ShellLinkKind
from ...common.table import FilePath, Name, Oriented, Table, Vector, entry, optional
from ...shell.description import MOST_REFINED, REFINE
from ...shell.loading import LINKS
from ...solid.description import SolidInterface
from .modes import Modes, Reference
from .section_schema import CHANGES


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


class Flexible(Reducible, Deformed):
    """Keys of every body that the preprocessor reduces."""

    reference: Reference = entry("reference condition", default=Reference())
    damping_ratio: float = entry(
        "of every mode of the body by itself; a mode of the mechanism at a lower frequency f, "
        "because the body carries masses, has about damping_ratio * f / f_body (docs/modes.md)",
        "-",
        0.0,
        ge=0,
        lt=1,
    )


class Meshed(Flexible):
    """Keys of shells and solids."""

    modes: list[Modes] = entry("which modes the solver gets", min_length=1)
    second_order: bool = entry(
        "second-order displacements of the modes, which geometric stiffening needs "
        "(docs/stiffening.md)",
        default=False,
    )


class ShellInterface(Oriented):
    """`[bodies.NAME.interfaces.NAME]` of a shell: a physical group of its mesh."""

    at: str = entry("physical point, curve or surface of the mesh")
    link: ShellLinkKind = entry(LINKS, default="rigid")


class ShellBody(Meshed):
    """`[bodies.NAME]` with kind = "shell": a laminated shell, its axes those of the mesh.

    Mesh, materials, laminates, regions, elements and stiffeners come from the description; its
    links, supports, loads, probes and frequencies are ignored.
    """

    kind: Literal["shell"]
    shell: FilePath = entry(
        "path of a shell description (docs/shell-description.md), relative to the case file"
    )
    parameters: dict[str, bool | float | str | list[float]] = entry(
        "of the mesh's script, over those of the description", default={}
    )
    refine: int = entry(
        f"{REFINE}; added to that of the description", default=0, ge=0, le=MOST_REFINED
    )
    changes: dict[str, Any] = entry(CHANGES, default={})
    mass_form: MassForm = entry(
        "inertia from consistent mass, or lumped (the paper)", default="consistent"
    )
    interfaces: dict[Name, ShellInterface] = entry(
        "named places; some carry the reference condition", min_length=1
    )


class SolidBody(Meshed):
    """`[bodies.NAME]` with kind = "solid": a part from CAD, its axes those of the file.

    Geometry, materials and regions come from the description; its own interfaces, supports, loads
    and frequencies are ignored.
    """

    kind: Literal["solid"]
    solid: FilePath = entry(
        "path of a solid description (docs/solids.md), relative to the case file"
    )
    size: float | None = optional("of the cells, over that of the description", "m", gt=0)
    interfaces: dict[Name, SolidInterface] = entry(
        "named places; some carry the reference condition", min_length=1
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
