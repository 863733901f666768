"""Keys for the modal reduction of a body: reference condition and modes."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ....errors import nearest
from ....package.specification import DIRECTIONS, Direction, ModeKind, ReferenceKind, SpinningKind
from ...common.table import Name, Table, entry, optional

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
        'interface that carries a clamped frame, absent: "root"; two for a chord, origin and '
        "twist at the first; none for a mean axis"
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
        if self.kind == "mean-axis" and self.at is not None:
            raise ValueError("expected no `at`: a mean axis has no interface")
        return self

    @property
    def places(self) -> list[str]:
        """Interfaces that carry the frame."""
        return [] if self.at is None else [self.at] if isinstance(self.at, str) else self.at


class ModeChoice(Table):
    """One entry of `modes`: the lowest vibration modes of a kind."""

    kind: ModeKind = entry(
        "told apart by their share of modal mass: xy bends in the body's x-y plane; of a shell: "
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
        (f"{key}.modes[{i}].at", mode.at)
        for i, mode in enumerate(modes)
        if isinstance(mode, AttachmentChoice)
    ]
    found = []
    for where, place in asked:
        if place not in fractions:
            default = where.endswith("reference.at") and place == DEFAULT_PLACE
            told = " (the default)" if default else ""
            found.append(f'{where} = "{place}"{told}: no such interface{nearest(place, fractions)}')
    found += [
        f'{key}.modes[{i}].kind = "{mode.kind}": expected reference.kind "clamped" or "chord" with '
        "it: a mean axis carries its first load"
        for i, mode in enumerate(modes)
        if isinstance(mode, SpinningChoice | StaticInertiaChoice) and reference.kind == "mean-axis"
    ]
    places = [fractions[place] for place in reference.places if place in fractions]
    if len(places) == 2 and places[0] == places[1]:
        found.append(f"{key}.reference.at = {reference.at}: expected two different places")
    return found


def check_places(key: str, body: Any) -> list[str]:
    """Return the same of a shell or solid, and errors in the interfaces that carry its frame."""
    places = {name: float(i) for i, name in enumerate(body.interfaces)}
    return check_modes(key, body.reference, body.modes, places) + [
        f'{key}.interfaces.{place}.link = "{body.interfaces[place].link}": expected "rigid": it '
        "carries the body frame"
        for place in body.reference.places
        if place in body.interfaces and body.interfaces[place].link != "rigid"
    ]
