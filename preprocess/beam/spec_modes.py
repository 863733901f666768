"""The reference condition and the requested modes in a beam specification."""

from dataclasses import dataclass
from typing import Any

from ...solver.package.body.schema import REFERENCE_CONDITIONS
from ..modes import CHOICES, ModeRequest
from .spec_values import SpecError, count, expected, known_keys, one_of

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")  # forces along and moments about the body axes
SPINNING = ("spinning-xy", "spinning-xz")
STATIC = ("attachment", "static-axial", *SPINNING)


@dataclass(frozen=True)
class Reference:
    """What ties the body frame to the beam.

    Attributes
    ----------
    kind : one of REFERENCE_CONDITIONS
    places : names of the places that carry the frame, with their fractions of the length
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
    static_axial : whether the shape under a load that increases along the beam is requested
    spinning : plane (one of SPINNING) and number of the shapes of a spinning beam
    """

    eigenmodes: tuple[ModeRequest, ...] = ()
    attachments: tuple[tuple[str, str], ...] = ()
    static_axial: bool = False
    spinning: tuple[tuple[str, int], ...] = ()


def read_reference(entry: Any, places: dict[str, float]) -> Reference:
    """Check the entry `reference`; `places` are the names it may use. Raises SpecError."""
    if not isinstance(entry, dict):
        raise SpecError(expected("reference", entry, "{'kind': 'clamped', 'at': interface}"))
    known_keys(entry, ("kind", "at"), "reference")
    kind = one_of(entry.get("kind", "clamped"), REFERENCE_CONDITIONS, "reference.kind")
    at = entry.get("at", "start" if kind == "clamped" else None)
    names: list[Any] = [at]
    if kind == "mean-axis":
        if at is not None:
            wish = "no such key with kind 'mean-axis', which needs no interface"
            raise SpecError(expected("reference.at", at, wish))
        names = []
    elif kind == "chord":
        if not isinstance(at, list) or len(at) != 2:
            raise SpecError(expected("reference.at", at, "two places: ['root', 'tip']"))
        names = at
    known = tuple(places)
    checked = [one_of(name, known, "reference.at") for name in names]
    found = tuple((name, places[name]) for name in checked)
    if kind == "chord" and abs(found[0][1] - found[1][1]) < 1e-9:
        raise SpecError(expected("reference.at", names, "two different places"))
    return Reference(kind, found)


def read_modes(entries: Any, interfaces: dict[str, float]) -> ModeSpec:
    """Check the entry `modes`. Raises SpecError."""
    if isinstance(entries, dict):
        entries = [entries]
    if not isinstance(entries, list):
        raise SpecError(expected("modes", entries, "a list of {'kind': ..., 'count': ...}"))
    eigenmodes: list[ModeRequest] = []
    attachments: list[tuple[str, str]] = []
    static_axial = False
    spinning: list[tuple[str, int]] = []
    for i, entry in enumerate(entries):
        where = f"modes[{i}]"
        if not isinstance(entry, dict):
            raise SpecError(expected(where, entry, "{'kind': ..., 'count': ...}"))
        kind = one_of(entry.get("kind", "lowest"), (*CHOICES, *STATIC), f"{where}.kind")
        if kind == "attachment":
            attachments += _attachments(entry, interfaces, where)
        elif kind == "static-axial":
            known_keys(entry, ("kind",), where)
            static_axial = True
        else:
            known_keys(entry, ("kind", "count"), where)
            number = count(entry.get("count"), f"{where}.count")
            if kind in SPINNING:
                spinning.append((kind, number))
            else:
                eigenmodes.append(ModeRequest(kind, number))
    return ModeSpec(tuple(eigenmodes), tuple(attachments), static_axial, tuple(spinning))


def _attachments(
    entry: dict[str, Any], interfaces: dict[str, float], where: str
) -> list[tuple[str, str]]:
    known_keys(entry, ("kind", "at", "directions"), where)
    at = one_of(entry.get("at"), tuple(interfaces), f"{where}.at")
    directions = entry.get("directions", list(DIRECTIONS))
    if not isinstance(directions, list) or not directions:
        wish = f"a list of {', '.join(DIRECTIONS)}"
        raise SpecError(expected(f"{where}.directions", directions, wish))
    return [(at, one_of(direction, DIRECTIONS, f"{where}.directions")) for direction in directions]
