"""Specification of a shell body, with axes and positions as arrays."""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ....solver.math.arrays import Array
from ....solver.math.rotations import vector_to_matrix
from ....solver.package.common.plain_data import check_form
from ....solver.package.specification import ShellInterfaceTable, ShellSpecification
from ...beam.spec import ModeSpec, Reference, read_modes, read_reference


@dataclass(frozen=True)
class ShellInterface:
    """A checked specification of an interface.

    Attributes
    ----------
    at : physical group of the mesh
    link : "rigid" (the group moves as a rigid body) or "average" (the interface follows its mean
     motion)
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
    reference : how the body frame is attached to the shell; its places are interfaces, by number
    modes : requested modes
    damping_ratio : of every mode, fraction of critical
    second_order : with second-order displacements, for geometric stiffening
    """

    body: str
    shell: dict[str, Any]
    mass_form: str
    interfaces: tuple[ShellInterface, ...]
    reference: Reference
    modes: ModeSpec
    damping_ratio: float
    second_order: bool = False


def read_shell_body(spec: dict[str, Any]) -> ShellBodySpec:
    """Read a specification (solver/package/specification.py).

    Raises
    ------
    SpecError : a key is unknown or missing, a value has another type, an interface does not exist.
    """
    check_form(spec, ShellSpecification)
    table = cast(ShellSpecification, spec)
    interfaces = tuple(_interface(name, entry) for name, entry in table["interfaces"].items())
    numbers = {interface.name: float(i) for i, interface in enumerate(interfaces)}
    elements = {**table["shell"]["elements"], "mass_form": table["mass_form"]}
    return ShellBodySpec(
        body=table["body"],
        shell={**table["shell"], "elements": elements, "links": _links(interfaces)},
        mass_form=table["mass_form"],
        interfaces=interfaces,
        reference=read_reference(table["reference"], numbers),
        modes=read_modes(table["modes"], numbers),
        damping_ratio=float(table["damping_ratio"]),
        second_order=table.get("second_order", False),
    )


def _interface(name: str, table: ShellInterfaceTable) -> ShellInterface:
    position = table.get("position")
    return ShellInterface(
        name=name,
        at=table["at"],
        link=table["link"],
        position_B=None if position is None else np.array(position, dtype=float),
        A_BI=vector_to_matrix(np.deg2rad(table["rotation_deg"])),
    )


def _links(interfaces: tuple[ShellInterface, ...]) -> dict[str, Any]:
    links: dict[str, Any] = {}
    for interface in interfaces:
        links[interface.name] = {"at": interface.at, "kind": interface.link}
        if interface.position_B is not None:
            links[interface.name]["point"] = interface.position_B.tolist()
    return links
