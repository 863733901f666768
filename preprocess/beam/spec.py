"""Specification of a beam body: the plain JSON of the case checker, checked again.

The case checker normally writes the specification, but a user may also write
one by hand. Therefore every value is checked here. An error names key, value and
expectation.
"""

from dataclasses import dataclass
from typing import Any

from ...solver.math.arrays import Array
from ...solver.package.body.schema import MASS_FORMS
from .line import section_axes
from .spec_modes import ModeSpec, Reference, read_modes, read_reference
from .spec_values import SpecError, count, expected, known_keys, number, one_of
from .theory import THEORIES

__all__ = ["BeamSpec", "SpecError", "read_spec"]

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


@dataclass(frozen=True)
class BeamSpec:
    """A checked specification of a beam body.

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
    reference : what ties the body frame to the beam
    modes : requested modes
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
    reference: Reference
    modes: ModeSpec
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
        raise SpecError(expected("kind", spec["kind"], "'beam'"))
    if not isinstance(spec["body"], str) or not spec["body"]:
        raise SpecError(expected("body", spec["body"], "a name"))
    elements = count(spec["elements"], "elements")
    if not isinstance(spec["section"], dict):
        raise SpecError(expected("section", spec["section"], "an object"))
    interfaces = _interfaces(spec["interfaces"])
    reference = read_reference(spec.get("reference", {}), {**ENDS, **interfaces})
    modes = read_modes(spec.get("modes", []), interfaces)
    if modes.spinning and reference.kind == "mean-axis":
        wish = f"a clamped or chord frame with modes of kind {modes.spinning[0][0]}"
        raise SpecError(expected("reference.kind", reference.kind, wish))
    return BeamSpec(
        body=spec["body"],
        length=number(spec["length"], "length", above=0.0, unit="m"),
        elements=elements,
        A_BE=_axes(spec.get("x2_axis", [0.0, 1.0, 0.0])),
        section=spec["section"],
        theory=one_of(spec.get("theory", "timoshenko"), THEORIES, "theory"),
        mass_form=one_of(spec.get("mass_form", "consistent"), MASS_FORMS, "mass_form"),
        interfaces=interfaces,
        reference=reference,
        modes=modes,
        damping_ratio=number(spec.get("damping_ratio", 0.0), "damping_ratio", least=0.0),
    )


def _axes(value: Any) -> Array:
    try:
        return section_axes(value)
    except (ValueError, TypeError) as error:
        wish = "a unit vector of 3 numbers orthogonal to the body x axis"
        raise SpecError(expected("x2_axis", value, wish)) from error


def _place(value: Any, key: str) -> float:
    if isinstance(value, str):
        if value not in ENDS:
            raise SpecError(expected(key, value, "'start', 'end' or a fraction of the length"))
        return ENDS[value]
    return number(value, key, least=0.0, most=1.0)


def _interfaces(table: Any) -> dict[str, float]:
    if not isinstance(table, dict) or not table:
        raise SpecError(expected("interfaces", table, "names with a place: {'tip': {'at': 'end'}}"))
    places = {}
    for name, entry in table.items():
        where = f"interfaces.{name}"
        if not isinstance(entry, dict) or "at" not in entry:
            raise SpecError(expected(where, entry, "{'at': place}"))
        known_keys(entry, ("at",), where)
        places[str(name)] = _place(entry["at"], f"{where}.at")
    return places
