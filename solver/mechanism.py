"""From a resolved run and its packages to a model, its names and its start."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import laws
from .assemble import (
    Body,
    JointTable,
    MarkerTable,
    assemble_model,
    flexible_body,
    rigid_body,
)
from .errors import InputError, nearest
from .initial import Start
from .model import GROUND, Model
from .package import Interface, ModalPackage
from .package.schema import Array
from .rotations import frame_from_axis, matrix_to_parameters, vector_to_matrix


@dataclass(frozen=True)
class BuiltMechanism:
    """A model ready to run, and the names that its numbers lost."""

    model: Model
    start: Start
    body_names: list[str]
    joint_names: list[str]  # one per joint row block, drives included
    packages: dict[str, ModalPackage]  # flexible bodies only
    places: dict[str, tuple[int, Interface]]  # "BODY.INTERFACE" -> body index, interface
    signal_marker: dict[str, int]  # signal -> marker index


class _Builder:
    def __init__(self, mechanism: dict[str, Any], packages: dict[str, ModalPackage]) -> None:
        self.mechanism, self.packages = mechanism, packages
        self.names = list(mechanism["bodies"])
        self.markers: list[MarkerTable] = []
        self.A_start = {
            name: vector_to_matrix(np.radians(np.array(body["rotation_deg"], dtype=float)))
            for name, body in mechanism["bodies"].items()
        }
        self.places = self._places()

    def _places(self) -> dict[str, tuple[int, Interface]]:
        places = {}
        for index, (name, body) in enumerate(self.mechanism["bodies"].items()):
            if name in self.packages:
                for interface in self.packages[name].interfaces:
                    places[f"{name}.{interface.name}"] = (index, interface)
                continue
            for point, table in body["interfaces"].items():
                places[f"{name}.{point}"] = (index, _rigid_interface(point, table["position"]))
        return places

    def bodies(self) -> list[Body]:
        found = []
        for name, table in self.mechanism["bodies"].items():
            if name in self.packages:
                found.append(flexible_body(name, self.packages[name]))
            else:
                found.append(
                    rigid_body(
                        name, table["mass"], np.array(table["centre"]), np.array(table["inertia"])
                    )
                )
        return found

    def place(self, key: str, place: str) -> tuple[int, Interface]:
        if place not in self.places:
            raise InputError(f'{key} = "{place}": no such interface{nearest(place, self.places)}')
        return self.places[place]

    def marker(self, key: str, place: str, A_GM: Array) -> int:
        """Add a marker at a place whose axes are A_GM in the starting position."""
        owner, _, point = place.partition(".")
        if owner == "ground":
            x = np.array(self.mechanism["ground"][point]["position"], dtype=float)
            self.markers.append(MarkerTable(GROUND, x, A_GM))
        else:
            body, interface = self.place(key, place)
            A_BM = self.A_start[owner].T @ A_GM
            self.markers.append(
                MarkerTable(body, interface.position_B, A_BM, interface.phi_B, interface.psi_B)
            )
        return len(self.markers) - 1

    def joints(self) -> list[JointTable]:
        found = []
        for name, joint in self.mechanism["joints"].items():
            axis = joint.get("axis", [0.0, 0.0, 1.0])
            A_GM = frame_from_axis(np.array(axis, dtype=float))
            key = f"joints.{name}.between"
            one, two = (self.marker(key, place, A_GM) for place in joint["between"])
            found.append(JointTable(name, joint["kind"], one, two))
            drive = joint.get("drive")
            if drive is not None:
                law = drive["polynomial"] or [drive["angle"], drive["speed"]]
                found.append(
                    JointTable(f"{name} (drive)", "rotation_drive", one, two, laws.polynomial(law))
                )
        return found

    def start(self, model: Model) -> Start:
        positions = np.zeros(model.n_pos)
        velocities = np.zeros(model.n_vel)
        given = np.ones(model.n_vel, dtype=bool)
        for i, (name, body) in enumerate(self.mechanism["bodies"].items()):
            a, j = int(model.pos_start[i]), int(model.vel_start[i])
            positions[a : a + 3] = body["position"]
            positions[a + 3 : a + 7] = matrix_to_parameters(self.A_start[name])
            for key, offset in (("velocity", 0), ("angular_velocity", 3)):
                part = slice(j + offset, j + offset + 3)
                if body[key] is None:
                    given[part] = False
                else:
                    velocities[part] = body[key]
        return Start(positions, velocities, given)


def _rigid_interface(name: str, position: list[float]) -> Interface:
    none = np.zeros((3, 0))
    return Interface(
        name,
        "node",
        np.zeros(0, dtype=np.int64),
        np.zeros(0),
        np.array(position, dtype=float),
        np.eye(3),
        none,
        none,
    )


def build(mechanism: dict[str, Any], packages: dict[str, ModalPackage]) -> BuiltMechanism:
    """Build the model of a checked mechanism (case/schema.py, as plain data).

    Raises
    ------
    InputError
        A place that a package does not have.
    """
    builder = _Builder(mechanism, packages)
    joints = builder.joints()
    masses = [
        (builder.marker(f"masses.{name}.at", mass["at"], np.eye(3)), float(mass["mass"]))
        for name, mass in mechanism["masses"].items()
    ]
    signal_marker = {
        name: builder.marker(f"signals.{name}.at", signal["at"], np.eye(3))
        for name, signal in mechanism["signals"].items()
    }
    solver = mechanism["solver"]
    model = assemble_model(
        builder.bodies(),
        builder.markers,
        joints,
        masses,
        mechanism["gravity"],
        solver["alpha"],
        solver["beta"],
    )
    return BuiltMechanism(
        model=model,
        start=builder.start(model),
        body_names=builder.names,
        joint_names=[j.name for j in joints],
        packages=packages,
        places=builder.places,
        signal_marker=signal_marker,
    )
