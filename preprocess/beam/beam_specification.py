"""Specification of a beam body, and the modes of a body specification."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ...solver.errors import did_you_mean, few
from ...solver.math.arrays import Array
from ...solver.package.body.invariants import rigid_motions
from ...solver.package.common.plain_data import SpecError, check_form, expected
from ...solver.package.specification import DIRECTIONS, BeamSpecification, LineTable, ReferenceTable
from ..modes.eigenmodes import ModeRequest
from ..modes.reduced import StaticLoad, inertia_loads
from .line import section_axes


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

    def static_loads(
        self, forces: Array, interfaces: Sequence[str], outwards: Array, places: Array
    ) -> list[StaticLoad]:
        """Loads of the static modes, but for those of a spinning beam.

        Parameters
        ----------
        forces : (n_dof, 6 i) unit forces and moments at the interfaces, on six dofs of each node
        interfaces : names
        outwards : (n,) centrifugal acceleration of the nodes along x at 1 rad/s [m/s2]
        places : (n, 3) nodes from the point about which rigid accelerations turn [m]
        """
        zero, loads = np.zeros(len(forces)), []
        for at, direction in self.attachments:
            force = forces[:, 6 * interfaces.index(at) + DIRECTIONS.index(direction)]
            loads.append(StaticLoad(f"attachment {at} {direction}", force, zero))
        if self.static_axial:
            along = np.outer(outwards, np.eye(6)[0]).ravel()
            loads.append(StaticLoad("static-axial", zero, along))
        if self.static_inertia:
            loads += inertia_loads(rigid_motions(places).reshape(-1, 6))
        return loads


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
            attachments += [
                (table["at"], direction) for direction in table.get("directions", DIRECTIONS)
            ]
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


ENDS = {"start": 0.0, "end": 1.0}


@dataclass(frozen=True)
class BeamSpec:
    """A checked specification of a beam body.

    Attributes
    ----------
    body : name
    length : [m]
    elements : number of elements
    nodes_B : (n, 3) nodes of a curved or twisted beam [m]; None: straight along x
    A_BE : (3, 3) section axes in body axes; with nodes those of each element, (n - 1, 3, 3)
    stations : fractions of the length, rising, where the sections are given; one if uniform
    sections : specification of the cross-section at each station (see `section.analyse`)
    theory : "timoshenko" or "classical" (no shear)
    mass_form : "consistent" or "lumped"
    interfaces : name and place as a fraction of the length
    reference : how the body frame is attached to the beam
    modes : requested modes
    damping_ratio : of every mode, fraction of critical
    errors : True if errors of the modal stiffness are estimated
    """

    body: str
    length: float
    elements: int
    nodes_B: Array | None
    A_BE: Array
    stations: tuple[float, ...]
    sections: tuple[dict[str, object], ...]
    theory: str
    mass_form: str
    interfaces: dict[str, float]
    reference: Reference
    modes: ModeSpec
    damping_ratio: float
    errors: bool = False


def read_spec(spec: Mapping[str, object]) -> BeamSpec:
    """Read a specification (solver/package/specification.py).

    Raises
    ------
    SpecError : an unknown or missing key, a value of another type, an interface without position.
    """
    table = check_form(spec, BeamSpecification)
    places = {name: entry["at"] for name, entry in table["interfaces"].items()}
    interfaces = {n: ENDS[at] if isinstance(at, str) else float(at) for n, at in places.items()}
    stations = table.get("stations") or [{"at": 0.0, "section": table["section"]}]
    at = tuple(float(station["at"]) for station in stations)
    if any(b <= a for a, b in pairwise(at)):
        raise SpecError(expected("stations", list(at), "rising fractions of the length"))
    nodes_B, A_BE = None, section_axes(table["x2_axis"])
    if "line" in table:
        nodes_B, A_BE = _line(table["line"])
    return BeamSpec(
        body=table["body"],
        length=float(table["length"]),
        elements=table["elements"],
        nodes_B=nodes_B,
        A_BE=A_BE,
        stations=at,
        sections=tuple(station["section"] for station in stations),
        theory=table["theory"],
        mass_form=table["mass_form"],
        interfaces=interfaces,
        reference=read_reference(table["reference"], interfaces),
        modes=read_modes(table["modes"], interfaces),
        damping_ratio=float(table["damping_ratio"]),
        errors=table.get("errors", False),
    )


def _line(table: LineTable) -> tuple[Array, Array]:
    """Nodes (n, 3) and section axes (n - 1, 3, 3) of a line. Raises SpecError."""
    try:
        nodes = np.array(table["nodes"], dtype=float).reshape(-1, 3)
        x2 = np.array(table["x2_axes"], dtype=float).reshape(-1, 3)
    except ValueError as error:
        raise SpecError("line: expected rows of three numbers") from error
    if len(nodes) < 2 or len(x2) != len(nodes) - 1:
        count = f"{len(nodes)} nodes and {len(x2)} axes"
        raise SpecError(f"line: expected one x2 axis less than nodes, found {count}")
    along = np.diff(nodes, axis=0)
    if not np.all(np.linalg.norm(along, axis=1) > 0.0):
        raise SpecError("line.nodes: two neighbours have the same position")
    e1 = along / np.linalg.norm(along, axis=1, keepdims=True)
    e2 = x2 - np.einsum("ea,ea->e", x2, e1)[:, None] * e1
    size = np.linalg.norm(e2, axis=1, keepdims=True)
    if not np.all(size > 1e-3):
        raise SpecError("line.x2_axes: an axis is along its element")
    e2 = e2 / size
    return nodes, np.stack([e1, e2, np.cross(e1, e2)], axis=2)
