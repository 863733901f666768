"""What a beam body is made of: the plain JSON of the case checker, checked again.

The specification is normally written by the case checker, but a user may write
one by hand, so every value is checked here and an error names key, value and
expectation.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...solver.errors import did_you_mean
from ...solver.package.schema import MASS_FORMS, Array
from ..modes import CHOICES, ModeRequest
from .line import section_axes
from .theory import THEORIES

REQUIRED = ("body", "kind", "length", "elements", "section", "interfaces")
OPTIONAL = (
    "x2_axis",
    "theory",
    "mass_form",
    "reference",
    "modes",
    "damping_ratio",
    "inputs_sha256",
    "case",
)
ENDS = {"start": 0.0, "end": 1.0}


class SpecError(ValueError):
    """A body specification that cannot be used; names key, value and expectation."""


@dataclass(frozen=True)
class BeamSpec:
    """A beam body as asked for.

    Attributes
    ----------
    body : name
    length : [m]
    elements : number of elements
    A_BE : (3, 3) section axes in body axes
    section : specification of the cross-section (see `section.analyse`)
    theory : "timoshenko" or "classical" (no shear)
    mass_form : "consistent" or "lumped"
    interfaces : name and place as a fraction of the length
    reference : name of the place that holds the body frame, and its fraction
    modes : what to keep
    damping_ratio : of every mode, fraction of critical
    """

    body: str
    length: float
    elements: int
    A_BE: Array
    section: dict[str, Any]
    theory: str
    mass_form: str
    interfaces: dict[str, float]
    reference: tuple[str, float]
    modes: tuple[ModeRequest, ...]
    damping_ratio: float


def read_spec(spec: dict[str, Any]) -> BeamSpec:
    """Check a specification.

    Raises
    ------
    SpecError : a key is unknown, missing or has an impossible value.
    """
    if not isinstance(spec, dict):
        raise SpecError(f"expected a JSON object, found {type(spec).__name__}")
    known_keys(spec, REQUIRED + OPTIONAL, "")
    for key in REQUIRED:
        if key not in spec:
            raise SpecError(f"{key}: missing; expected {', '.join(REQUIRED)}")
    if spec["kind"] != "beam":
        raise SpecError(_expected("kind", spec["kind"], "'beam'"))
    if not isinstance(spec["body"], str) or not spec["body"]:
        raise SpecError(_expected("body", spec["body"], "a name"))
    elements = spec["elements"]
    if isinstance(elements, bool) or not isinstance(elements, int) or elements < 1:
        raise SpecError(_expected("elements", elements, "a whole number of at least 1"))
    if not isinstance(spec["section"], dict):
        raise SpecError(_expected("section", spec["section"], "an object"))
    interfaces = _interfaces(spec["interfaces"])
    return BeamSpec(
        body=spec["body"],
        length=number(spec["length"], "length", above=0.0, unit="m"),
        elements=elements,
        A_BE=_axes(spec.get("x2_axis", [0.0, 1.0, 0.0])),
        section=spec["section"],
        theory=_one_of(spec.get("theory", "timoshenko"), THEORIES, "theory"),
        mass_form=_one_of(spec.get("mass_form", "consistent"), MASS_FORMS, "mass_form"),
        interfaces=interfaces,
        reference=_reference(spec.get("reference", {"kind": "clamped", "at": "start"}), interfaces),
        modes=_modes(spec.get("modes", [])),
        damping_ratio=number(spec.get("damping_ratio", 0.0), "damping_ratio", least=0.0),
    )


def known_keys(table: dict[str, Any], known: tuple[str, ...], where: str) -> None:
    """Raise SpecError for the first key that is not known, with the nearest that is."""
    for key in table:
        if key not in known:
            hint = did_you_mean(str(key), known)
            name = f"{where}.{key}" if where else str(key)
            raise SpecError(f"{name}: unknown key{hint} (known: {', '.join(known)})")


def number(
    value: Any,
    key: str,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
    unit: str = "",
) -> float:
    """Return a finite number within its bounds; SpecError names the key otherwise."""
    bounds = [
        f"{word} {bound:g}"
        for word, bound in (("above", above), ("of at least", least), ("of at most", most))
        if bound is not None
    ]
    wish = " ".join(["a number", " and ".join(bounds), f"[{unit}]" if unit else ""]).strip()
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise SpecError(_expected(key, value, wish))
    inside = (
        (above is None or value > above)
        and (least is None or value >= least)
        and (most is None or value <= most)
    )
    if not inside:
        raise SpecError(_expected(key, value, wish))
    return float(value)


def _expected(key: str, value: Any, wish: str) -> str:
    return f"{key}: expected {wish}, found {value!r}"


def _one_of(value: Any, known: tuple[str, ...], key: str) -> str:
    if value not in known:
        hint = did_you_mean(str(value), known)
        raise SpecError(_expected(key, value, f"one of {', '.join(known)}") + hint)
    return str(value)


def _axes(value: Any) -> Array:
    try:
        return section_axes(value)
    except (ValueError, TypeError) as error:
        wish = "a unit vector of 3 numbers orthogonal to the body x axis"
        raise SpecError(_expected("x2_axis", value, wish)) from error


def _place(value: Any, key: str) -> float:
    if isinstance(value, str):
        if value not in ENDS:
            raise SpecError(_expected(key, value, "'start', 'end' or a fraction of the length"))
        return ENDS[value]
    return number(value, key, least=0.0, most=1.0)


def _interfaces(table: Any) -> dict[str, float]:
    if not isinstance(table, dict) or not table:
        raise SpecError(
            _expected("interfaces", table, "names with a place: {'tip': {'at': 'end'}}")
        )
    places = {}
    for name, entry in table.items():
        where = f"interfaces.{name}"
        if not isinstance(entry, dict) or "at" not in entry:
            raise SpecError(_expected(where, entry, "{'at': place}"))
        known_keys(entry, ("at",), where)
        places[str(name)] = _place(entry["at"], f"{where}.at")
    return places


def _reference(entry: Any, interfaces: dict[str, float]) -> tuple[str, float]:
    if not isinstance(entry, dict):
        raise SpecError(_expected("reference", entry, "{'kind': 'clamped', 'at': interface}"))
    known_keys(entry, ("kind", "at"), "reference")
    _one_of(entry.get("kind", "clamped"), ("clamped",), "reference.kind")
    places = {**ENDS, **interfaces}
    at = _one_of(entry.get("at", "start"), tuple(places), "reference.at")
    return at, places[at]


def _modes(entries: Any) -> tuple[ModeRequest, ...]:
    if isinstance(entries, dict):
        entries = [entries]
    if not isinstance(entries, list):
        raise SpecError(_expected("modes", entries, "a list of {'kind': ..., 'count': ...}"))
    requests = []
    for i, entry in enumerate(entries):
        where = f"modes[{i}]"
        if not isinstance(entry, dict):
            raise SpecError(_expected(where, entry, "{'kind': ..., 'count': ...}"))
        known_keys(entry, ("kind", "count"), where)
        kind = _one_of(entry.get("kind", "lowest"), CHOICES, f"{where}.kind")
        count = entry.get("count")
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise SpecError(_expected(f"{where}.count", count, "a whole number of at least 1"))
        requests.append(ModeRequest(kind, count))
    return tuple(requests)
