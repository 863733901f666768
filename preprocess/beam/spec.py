"""Specification of a beam body, with positions and axes as numbers."""

from dataclasses import dataclass
from typing import Any, cast

from ...solver.math.arrays import Array
from ...solver.package.body.specification import BeamSpecification
from ...solver.package.common.table_form import check_form
from .line import section_axes
from .spec_modes import ModeSpec, Reference, read_modes, read_reference

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
    reference : how the body frame is attached to the beam
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
    """Read a specification (solver/package/body/specification.py).

    Raises
    ------
    SpecError : an unknown or missing key, a value of another type, an interface without position.
    """
    check_form(spec, BeamSpecification)
    table = cast(BeamSpecification, spec)
    places = {name: entry["at"] for name, entry in table["interfaces"].items()}
    interfaces = {n: ENDS[at] if isinstance(at, str) else float(at) for n, at in places.items()}
    return BeamSpec(
        body=table["body"],
        length=float(table["length"]),
        elements=table["elements"],
        A_BE=section_axes(table["x2_axis"]),
        section=table["section"],
        theory=table["theory"],
        mass_form=table["mass_form"],
        interfaces=interfaces,
        reference=read_reference(table["reference"], interfaces),
        modes=read_modes(table["modes"], interfaces),
        damping_ratio=float(table["damping_ratio"]),
    )
