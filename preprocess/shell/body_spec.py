"""Specification of a shell body: the plain JSON of the case checker, checked again.

{"body": "hand", "kind": "shell",
 "shell": {"mesh": {...}, "materials": {...}, "laminates": {...}, "regions": {...},
           "elements": {...}, "stiffeners": {...}},          see spec.py; no supports, no loads
 "mass_form": "consistent",                                  or "lumped": of modes and invariants
 "reference": {"kind": "clamped", "at": "root"},             or chord (two), mean-axis (none)
 "modes": [{"kind": "lowest", "count": 8}, {"kind": "attachment", "at": "tip"}],
 "interfaces": {"root": {"at": "left edge", "link": "rigid"},
                "tip": {"at": "right edge", "link": "average", "position": [0.7, 0.0, 0.0],
                        "rotation_deg": [0.0, 0.0, 90.0]}},
 "damping_ratio": 0.0}

The body's axes are those of the mesh. Lengths in m.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...solver.math.arrays import Array
from ...solver.math.rotations import vector_to_matrix
from ...solver.package.body.schema import MASS_FORMS
from ..beam.spec_modes import ModeSpec, Reference, read_modes, read_reference
from ..beam.spec_values import SpecError, expected, known_keys, number, one_of
from .links import KINDS

REQUIRED = ("body", "kind", "shell", "interfaces")
OPTIONAL = ("mass_form", "reference", "modes", "damping_ratio", "inputs_sha256", "case")
PARTS = ("mesh", "materials", "laminates", "regions", "elements", "stiffeners")
INTERFACE = ("at", "link", "position", "rotation_deg")


@dataclass(frozen=True)
class ShellInterface:
    """A checked specification of an interface.

    Attributes
    ----------
    at : physical group of the mesh
    link : "rigid" (the group moves as one) or "average" (the interface follows its mean motion)
    position_B : (3,) reference point, None for the centre of the group [m]
    A_BI : (3, 3) interface axes in body axes
    """

    name: str
    at: str
    link: str
    position_B: Array | None
    A_BI: Array


@dataclass(frozen=True)
class ShellBodySpec:
    """A checked specification of a shell body.

    Attributes
    ----------
    body : name
    shell : specification of the shell, with links for the interfaces and the mass form
    mass_form : "consistent" or "lumped"
    interfaces : in the order of the links
    reference : what ties the body frame to the shell; its places are interfaces, by number
    modes : requested modes
    damping_ratio : of every mode, fraction of critical
    """

    body: str
    shell: dict[str, Any]
    mass_form: str
    interfaces: tuple[ShellInterface, ...]
    reference: Reference
    modes: ModeSpec
    damping_ratio: float


def read_shell_body(spec: dict[str, Any]) -> ShellBodySpec:
    """Check a specification.

    Raises
    ------
    SpecError : a key is unknown, missing or has an impossible value.
    """
    known_keys(spec, REQUIRED + OPTIONAL, "")
    for key in REQUIRED:
        if key not in spec:
            raise SpecError(f"{key}: missing; expected {', '.join(REQUIRED)}")
    if not isinstance(spec["body"], str) or not spec["body"]:
        raise SpecError(expected("body", spec["body"], "a name"))
    interfaces = _interfaces(spec["interfaces"])
    mass_form = one_of(spec.get("mass_form", "consistent"), MASS_FORMS, "mass_form")
    numbers = {interface.name: float(i) for i, interface in enumerate(interfaces)}
    reference = _reference(spec.get("reference", {}), interfaces, numbers)
    modes = read_modes(spec.get("modes", []), numbers)
    if any(request.kind == "torsion" for request in modes.eigenmodes):
        wish = "lowest, or bending-xy, bending-xz, axial: largest motion along y, z, x"
        raise SpecError(
            expected("modes.kind", "torsion", wish) + " (twist is motion along y and z)"
        )
    if modes.spinning:
        wish = "lowest, bending-xy, bending-xz, axial, attachment or static-axial of a shell"
        raise SpecError(expected("modes.kind", modes.spinning[0][0], wish))
    return ShellBodySpec(
        body=spec["body"],
        shell=_shell(spec["shell"], interfaces, mass_form),
        mass_form=mass_form,
        interfaces=interfaces,
        reference=reference,
        modes=modes,
        damping_ratio=number(spec.get("damping_ratio", 0.0), "damping_ratio", least=0.0),
    )


def _shell(table: Any, interfaces: tuple[ShellInterface, ...], mass_form: str) -> dict[str, Any]:
    if not isinstance(table, dict):
        raise SpecError(expected("shell", table, "an object"))
    known_keys(table, PARTS, "shell")
    links: dict[str, Any] = {}
    for interface in interfaces:
        links[interface.name] = {"at": interface.at, "kind": interface.link}
        if interface.position_B is not None:
            links[interface.name]["point"] = interface.position_B.tolist()
    elements = table.get("elements", {})
    if not isinstance(elements, dict):
        raise SpecError(expected("shell.elements", elements, "an object"))
    return {**table, "elements": {**elements, "mass_form": mass_form}, "links": links}


def _interfaces(table: Any) -> tuple[ShellInterface, ...]:
    if not isinstance(table, dict) or not table:
        wish = "names with a physical group: {'root': {'at': 'left edge', 'link': 'rigid'}}"
        raise SpecError(expected("interfaces", table, wish))
    found = []
    for name, entry in table.items():
        where = f"interfaces.{name}"
        if not isinstance(entry, dict) or not isinstance(entry.get("at"), str):
            raise SpecError(expected(where, entry, "{'at': physical group of the mesh}"))
        known_keys(entry, INTERFACE, where)
        position = entry.get("position")
        turn = _vector(entry.get("rotation_deg", [0.0, 0.0, 0.0]), f"{where}.rotation_deg")
        found.append(
            ShellInterface(
                name=str(name),
                at=entry["at"],
                link=one_of(entry.get("link", "rigid"), KINDS, f"{where}.link"),
                position_B=None if position is None else _vector(position, f"{where}.position"),
                A_BI=vector_to_matrix(np.deg2rad(turn)),
            )
        )
    return tuple(found)


def _reference(
    entry: Any, interfaces: tuple[ShellInterface, ...], numbers: dict[str, float]
) -> Reference:
    if isinstance(entry, dict) and entry.get("kind", "clamped") == "clamped":
        entry = {"at": "root", **entry}
    reference = read_reference(entry, numbers)
    links = {interface.name: interface.link for interface in interfaces}
    for name, _ in reference.places:
        if links[name] != "rigid":
            wish = f"'rigid': it carries the frame (reference.at = {name!r}), which holds the group"
            raise SpecError(expected(f"interfaces.{name}.link", links[name], wish))
    return reference


def _vector(value: Any, key: str) -> Array:
    if not isinstance(value, list) or len(value) != 3:
        raise SpecError(expected(key, value, "a list of 3 numbers"))
    return np.array([number(v, f"{key}[{i}]") for i, v in enumerate(value)])
