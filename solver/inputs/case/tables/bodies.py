"""Keys of bodies of all kinds but beams; of their reference condition, modes and sections."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import ConfigDict, Field, ValidationInfo, field_validator, model_validator

from ....errors import nearest
from ....package.specification import (
    DIRECTIONS,
    Direction,
    MassForm,
    ModeKind,
    ReferenceKind,
    ShellLinkKind,
    SpinningKind,
)
from ...common.input_table import FilePath, Name, Oriented, Table, Vector, entry, optional
from ...common.text_file import read_toml
from ...common.units import UNITS, unit_of
from ...section.description import ShapeMesh, shape_or
from ...shell import LINKS, MOST_REFINED, REFINE
from ...solid import SolidInterface
from ...solid_specification import solid_table
from .laws import FOLDER

DEFAULT_PLACE = "root"  # of a clamped frame


class Reference(Table):
    """`[bodies.NAME.reference]`: how the body frame is tied to the deformed body."""

    kind: ReferenceKind = entry(
        "clamped: frame fixed to one node, its position and tangent; chord: x axis through two "
        "nodes; mean-axis: mean position of the deforming body, which has no momentum in this "
        "frame",
        default="clamped",
    )
    at: Name | list[Name] | None = optional(
        'interface that carries a clamped frame, absent: "root", or the only one at the start of a '
        "beam; two for a chord, origin and twist at the first; none for a mean axis, or two of a "
        "beam, which carry the loads of static shapes as those of a chord do"
    )

    @model_validator(mode="before")
    @classmethod
    def _at_root(cls, table: Any) -> Any:
        if isinstance(table, dict) and table.get("kind", "clamped") == "clamped":
            return {"at": DEFAULT_PLACE, **table}
        return table

    @model_validator(mode="after")
    def _places(self) -> "Reference":
        if self.kind == "clamped" and not isinstance(self.at, str):
            raise ValueError("expected `at` with one interface")
        if self.kind == "chord" and not (isinstance(self.at, list) and len(self.at) == 2):
            raise ValueError('expected `at` with two interfaces, such as ["root", "tip"]')
        if self.kind == "mean-axis" and len(self.places) not in (0, 2):
            raise ValueError("expected no `at` of a mean axis, or two interfaces of a beam")
        return self

    @property
    def places(self) -> list[str]:
        """Interfaces that carry the frame."""
        return [] if self.at is None else [self.at] if isinstance(self.at, str) else self.at


class ModeChoice(Table):
    """One entry of `modes`: the lowest vibration modes of a kind."""

    kind: ModeKind = entry(
        "distinguished by their share of modal mass: xy bends in the body's x-y plane; of a shell: "
        "what moves most along y, z, x, and no torsion"
    )
    count: int = entry("how many, lowest frequencies first", ge=1, le=200)


class AttachmentChoice(Table):
    """One entry of `modes` with kind = "attachment": the static shapes of unit loads.

    Only their parts that the vibration modes do not contain are added, see docs/modes.md.
    """

    kind: Literal["attachment"]
    at: Name = entry("interface where the loads act: a joint, a mass, a spring")
    directions: list[Direction] = entry(
        "forces along and moments about the body axes", default=list(DIRECTIONS), min_length=1
    )


class StaticAxialChoice(Table):
    """One entry of `modes` with kind = "static-axial": the shape under centrifugal load.

    A load per length that increases along body x, from zero at the node that carries the frame.
    """

    kind: Literal["static-axial"]


class StaticInertiaChoice(Table):
    """One entry of `modes` with kind = "static-inertia": the shapes under inertia loads, six.

    The loads of rigid accelerations along and about the body axes.
    """

    kind: Literal["static-inertia"]


class SpinningChoice(Table):
    """One entry of `modes` with kind = "spinning-xy", "spinning-xz": bending under tension by spin.

    Static shapes of a beam, accurate at rest and at speed; with geometric stiffening.
    """

    kind: SpinningKind = entry("plane of bending: the beam spins about an axis across it")
    count: int = entry("how many; four give frequencies to 1e-4", ge=1, le=8)


Modes = Annotated[
    ModeChoice | AttachmentChoice | StaticAxialChoice | StaticInertiaChoice | SpinningChoice,
    Field(discriminator="kind"),
]


def check_modes(
    key: str, reference: Reference, modes: list[Modes], fractions: dict[str, float]
) -> list[str]:
    """Return errors in the names of a body's reference condition and modes.

    Parameters
    ----------
    key : of the body
    fractions : place of each interface: of the length of a beam; any, but different, of a shell
    """
    asked = [(f"{key}.reference.at", place) for place in reference.places]
    asked += [
        (f"{key}.modes.{i}.at", mode.at)
        for i, mode in enumerate(modes)
        if isinstance(mode, AttachmentChoice)
    ]
    errors = []
    for where, place in asked:
        if place not in fractions:
            default = where.endswith("reference.at") and place == DEFAULT_PLACE
            note = " (the default)" if default else ""
            errors.append(
                f'{where} = "{place}"{note}: no such interface{nearest(place, fractions)}'
            )
    errors += [
        f'{key}.modes.{i}.kind = "{mode.kind}": expected reference.kind "clamped" or "chord" with '
        "it: a mean axis carries its first load"
        for i, mode in enumerate(modes)
        if isinstance(mode, SpinningChoice | StaticInertiaChoice)
        and reference.kind == "mean-axis"
        and not reference.places
    ]
    places = [fractions[place] for place in reference.places if place in fractions]
    if len(places) == 2 and places[0] == places[1]:
        errors.append(f"{key}.reference.at = {reference.at}: expected two different places")
    return errors


def check_places(key: str, body: Any) -> list[str]:
    """Return the same of a shell or solid, and errors in the interfaces that carry its frame."""
    reference, places = body.reference, {name: float(i) for i, name in enumerate(body.interfaces)}
    errors = check_modes(key, reference, body.modes, places)
    if reference.kind == "mean-axis" and reference.places:
        errors.append(f"{key}.reference.at = {reference.at}: expected none of a {body.kind}")
    return errors + [
        f'{key}.interfaces.{place}.link = "{body.interfaces[place].link}": expected "rigid": it '
        "carries the body frame"
        for place in reference.places
        if place in body.interfaces and body.interfaces[place].link != "rigid"
    ]


CHANGES = "other values at dotted keys of the description, in quotes: " + (
    '{ "laminates.wall.angles_deg.1" = 30 }'
)


class DescribedSection(Table):
    """`[sections.NAME]` with `file` or `description`: a section with lay-ups, or its own mesh.

    Keys of a description: docs/section-description.md.
    """

    one_of = ("file", "description")

    file: FilePath | None = optional("path of a section description, relative to the case file")
    description: dict[str, object] | None = optional(
        "instead: the description itself, without format and title; it may use the materials of "
        "the case"
    )
    changes: dict[str, object] = entry(CHANGES, default={})

    @model_validator(mode="before")
    @classmethod
    def _in_units_of_the_case(cls, data: Any, info: ValidationInfo) -> Any:
        inner, unit = data.get("description") if isinstance(data, dict) else None, unit_of(info)
        if unit == "m" or not isinstance(inner, dict):
            return data
        return {**data, "description": {UNITS: unit, **inner}}


if TYPE_CHECKING:
    Section = ShapeMesh | DescribedSection
else:
    Section = shape_or(DescribedSection)


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
    changes: dict[str, object] = entry(CHANGES, default={})
    mass_form: MassForm = entry(
        "inertia from consistent mass, or lumped (the paper)", default="consistent"
    )
    interfaces: dict[Name, ShellInterface] = entry(
        "named places; some carry the reference condition", min_length=1
    )


class SolidBody(Meshed):
    """`[bodies.NAME]` with kind = "solid": a part from CAD, its axes those of the file.

    Geometry, materials and regions come from the description, and the interfaces if the case gives
    none; its supports, loads and frequencies are ignored.
    """

    kind: Literal["solid"]
    solid: FilePath = entry(
        "path of a solid description (docs/solids.md), relative to the case file"
    )
    size: float | None = optional("of the cells, over that of the description", "m", gt=0)
    interfaces: dict[Name, SolidInterface] = entry(
        "named places; some carry the reference condition; absent: those of the description",
        default={},
        min_length=1,
    )

    @model_validator(mode="before")
    @classmethod
    def _described(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict) or "interfaces" in data or "solid" not in data:
            return data
        file = Path((info.context or {}).get(FOLDER, "."), str(data["solid"]))
        description, _ = solid_table(read_toml(file, "solid description"), file)
        return {**data, "interfaces": description.interfaces}


class RigidBody(Placed):
    """`[bodies.NAME]` with kind = "rigid"."""

    kind: Literal["rigid"]
    mass: float = entry("mass; 0 of a link whose others carry mass", "kg", ge=0)
    centre: Vector = entry("mass centre in the body frame", "m", [0.0, 0.0, 0.0])
    inertia: list[Vector] = entry(
        "3x3 inertia about the mass centre, body axes, [[Jxx, Jxy, Jxz], [Jxy, Jyy, Jyz], "
        "[Jxz, Jyz, Jzz]]; symmetric, positive definite; moments may be 0 if the mass is, or with "
        'allow = ["inertia"]',
        "kg m2",
        min_length=3,
        max_length=3,
    )
    interfaces: dict[Name, PointInterface] = entry("named places", default={})
    picture: FilePath | None = optional(
        "for pictures only: path of an STL file in body axes [m], relative to the case file; "
        "absent: a box of the same inertia"
    )

    @field_validator("picture")
    @classmethod
    def _found(cls, value: str | None, info: ValidationInfo) -> str | None:
        folder = (info.context or {}).get(FOLDER)
        if value is None or folder is None:
            return value
        file = Path(folder) / value
        if not file.is_file():
            raise ValueError("no such file")
        return str(file.resolve())


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
    file: FilePath = entry(
        "path of the import file (TOML), relative to the case file", alias="import"
    )
