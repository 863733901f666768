"""The reference condition and the modes of a body specification, as beams and shells use them."""

from dataclasses import dataclass
from typing import Any

from ...solver.errors import did_you_mean, few
from ...solver.package.body.specification import ReferenceTable
from ...solver.package.common.table_form import SpecError, expected
from ..modes import ModeRequest


@dataclass(frozen=True)
class Reference:
    """Reference condition: how the body frame is attached to the body.

    Attributes
    ----------
    kind : one of REFERENCE_CONDITIONS
    places : names of the interfaces that carry the frame, with their fractions of the length of a
        beam, or their numbers in a shell
    """

    kind: str
    places: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class ModeSpec:
    """The requested modes of a body.

    Attributes
    ----------
    eigenmodes : kinds and counts
    attachments : interface and direction (one of DIRECTIONS) of each unit load
    static_axial : True if the shape under a load that increases along the beam is requested
    static_inertia : True if the shapes under inertia loads of rigid accelerations are requested
    spinning : plane and number of the shapes of a spinning beam
    """

    eigenmodes: tuple[ModeRequest, ...] = ()
    attachments: tuple[tuple[str, str], ...] = ()
    static_axial: bool = False
    static_inertia: bool = False
    spinning: tuple[tuple[str, int], ...] = ()


def read_reference(table: ReferenceTable, places: dict[str, float]) -> Reference:
    """Find the interfaces that carry the frame; `places` has them all. Raises SpecError."""
    at = table.get("at", [])
    names = [at] if isinstance(at, str) else at
    for name in names:
        _known(name, places, "reference.at")
    return Reference(table["kind"], tuple((name, places[name]) for name in names))


def read_modes(tables: list[Any], places: dict[str, float]) -> ModeSpec:
    """Sort the requested modes by kind. Raises SpecError for a load at an unknown interface."""
    eigenmodes: list[ModeRequest] = []
    attachments: list[tuple[str, str]] = []
    static_axial = static_inertia = False
    spinning: list[tuple[str, int]] = []
    for i, table in enumerate(tables):
        kind = table["kind"]
        if kind == "attachment":
            _known(table["at"], places, f"modes[{i}].at")
            attachments += [(table["at"], direction) for direction in table["directions"]]
        elif kind == "static-axial":
            static_axial = True
        elif kind == "static-inertia":
            static_inertia = True
        elif kind.startswith("spinning-"):
            spinning.append((kind, table["count"]))
        else:
            eigenmodes.append(ModeRequest(kind, table["count"]))
    return ModeSpec(
        tuple(eigenmodes), tuple(attachments), static_axial, static_inertia, tuple(spinning)
    )


def _known(name: str, places: dict[str, float], key: str) -> None:
    if name not in places:
        known = f"one of the interfaces {few(places)}"
        raise SpecError(expected(key, name, known) + did_you_mean(name, places))
