"""Build the model of a mechanism, with its names and its start."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import compress
from typing import TYPE_CHECKING

import numpy as np

from ...dynamics.model.model import Model
from ...math.rotations import matrix_to_parameters, vector_to_matrix
from ...package import Interface, ModalPackage
from ..assembly.assembly import assemble_model
from ..assembly.tables import Body, flexible_body, rigid_body
from ..consistent.initial import Start
from .case_tables import BuiltJoint, Reader, coupling_rows, force_tables, joint_tables
from .modes import modal_values
from .places import Places
from .virtual import HEAVY, VirtualBodies, through_virtual_bodies

if TYPE_CHECKING:
    from ...inputs.case.tables.schema import Mechanism


MODERATE = 100.0  # mass point over its body: far from round-off


@dataclass(frozen=True)
class BuiltMechanism:
    """A model with the names of its bodies, joints and places."""

    model: Model
    start: Start
    body_names: list[str]  # bodies of the case, then virtual bodies
    joint_names: list[str]  # one per joint row block, drives included
    packages: dict[str, ModalPackage]  # flexible bodies only
    places: dict[str, tuple[int, Interface]]  # "BODY.INTERFACE" -> body index, interface
    joints: dict[str, BuiltJoint]  # joints of the case
    signal_marker: dict[str, int]  # signal of a place -> marker index
    state_names: list[str]  # auxiliary states, without those that count turns
    light: Callable[[], Model]  # the same with mass points of moderate mass (`heaviest` of `build`)
    force_names: list[str]  # in the order of the force elements of the model
    callers: tuple[str, ...] = ()  # forces whose values come from functions of the user
    point_masses: tuple[tuple[int, float], ...] = ()  # marker and mass [kg], not of virtual bodies


def build(
    mechanism: "Mechanism",
    packages: dict[str, ModalPackage],
    *,
    stiffening: bool = False,
    heaviest: float = np.inf,
) -> BuiltMechanism:
    """Build the model of a checked mechanism (inputs/case/tables/schema.py).

    `stiffening` gives every body its second-order terms whatever the mechanism says; `heaviest` is
    the largest ratio of a mass point to its body, heavier ones are taken as so heavy.

    Raises
    ------
    InputError
        A package has no such interface; a distance joint has length zero.
    """
    places = Places(mechanism, packages)
    stiffening = stiffening or mechanism.solver.geometric_stiffening
    bodies = _bodies(mechanism, packages, stiffening=stiffening)
    joints, built_joints = joint_tables(mechanism, places)
    reader = Reader(mechanism, places, built_joints, joints)
    forces = force_tables(mechanism, places, reader)
    reader.found.couplings += coupling_rows(mechanism, reader)
    masses = [
        (places.marker(f"masses.{name}.at", mass.at, np.eye(3)), mass.mass)
        for name, mass in mechanism.masses.items()
    ]
    own = [bodies[places.markers[k].body].invariants.mass for k, _ in masses]
    heavy = [0.0 < HEAVY * body < m for (_, m), body in zip(masses, own, strict=True)]
    if heaviest < np.inf:
        masses = [
            (k, min(m, heaviest * body) if body > 0.0 else m)
            for (k, m), body in zip(masses, own, strict=True)
        ]
    signal_marker: dict[str, int] = {}
    watched: dict[str, int] = {}  # place -> marker, which its signals share
    for name, signal in mechanism.signals.items():
        if (at := getattr(signal, "at", None)) is not None:  # signals of a place
            if at not in watched:
                watched[at] = places.marker(f"signals.{name}.at", at, np.eye(3))
            signal_marker[name] = watched[at]
    for name, signal in mechanism.signals.items():
        frame = getattr(signal, "frame", None)
        if frame is None:
            continue
        A_GM = vector_to_matrix(np.radians(np.array(frame.rotation_deg)))  # a body in segments
        for number, at in enumerate(frame.places):
            marker = places.marker(f"signals.{name}.at", at, A_GM)
            signal_marker[frame_marker(name, number)] = marker
    virtual = VirtualBodies([], places.markers, joints)
    if mechanism.solver.attachment == "virtual":
        virtual = through_virtual_bodies(bodies, places.markers, joints)
    if any(heavy):
        names = [f"masses.{name}" for name in compress(mechanism.masses, heavy)]
        virtual = virtual.with_masses(bodies, names, list(compress(masses, heavy)))
        masses = [mass for mass, apart in zip(masses, heavy, strict=True) if not apart]
    model = assemble_model(
        bodies + virtual.bodies,
        virtual.markers,
        virtual.joints,
        masses,
        np.array(mechanism.gravity),
        forces=forces,
        measured=reader.found,
    )
    model = model._replace(quantities=model.quantities._replace(end=mechanism.solver.t_end))
    return BuiltMechanism(
        model=virtual.scaled(model),
        start=_start(mechanism, places, virtual, model, packages),
        body_names=list(mechanism.bodies),
        joint_names=[joint.name for joint in virtual.joints] + list(mechanism.couplings),
        packages=packages,
        places=places.known,
        joints=built_joints,
        signal_marker=signal_marker,
        state_names=[state.name for state in reader.found.states],
        light=lambda: build(mechanism, packages, stiffening=stiffening, heaviest=MODERATE).model,
        force_names=list(mechanism.forces),
        callers=tuple(s.owner for s in reader.found.states if s.inputs is not None),
        point_masses=tuple(masses),
    )


def frame_marker(signal: str, number: int) -> str:
    """Return the name of a marker that carries the frame of a signal of a body in segments."""
    return f"{signal}#{number}"


def _bodies(
    mechanism: "Mechanism", packages: dict[str, ModalPackage], *, stiffening: bool
) -> list[Body]:
    return [
        rigid_body(name, body.mass, np.array(body.centre), np.array(body.inertia))
        if body.kind == "rigid"
        else flexible_body(name, packages[name], stiffening=stiffening)
        for name, body in mechanism.bodies.items()
    ]


def _start(
    mechanism: "Mechanism",
    places: Places,
    virtual: VirtualBodies,
    model: Model,
    packages: dict[str, ModalPackage],
) -> Start:
    """Return the given start; what is not given is free to follow from joints and drives."""
    positions = np.zeros(model.n_pos)
    velocities = np.zeros(model.n_vel)
    given = np.zeros(model.n_vel, dtype=bool)
    still = mechanism.solver.modes_at_start == "still"
    frames = list(zip(places.r_start, places.A_start, strict=True))
    for i, (r, A) in enumerate([*frames, *virtual.frames(places.r_start, places.A_start)]):
        a = int(model.pos_start[i])
        positions[a : a + 3] = r
        positions[a + 3 : a + 7] = matrix_to_parameters(A)
    for i, (name, body) in enumerate(mechanism.bodies.items()):
        j = int(model.vel_start[i])
        given[j : j + 6] = True
        given[j + 6 : j + 6 + int(model.n_mode[i])] = still
        for value, offset in ((body.velocity, 0), (body.angular_velocity, 3)):
            part = slice(j + offset, j + offset + 3)
            if value is None:
                given[part] = False
            else:
                velocities[part] = value
        if body.kind != "rigid":
            first = int(model.pos_start[i]) + 7
            for k, q in modal_values(name, "modal_coordinates", body, packages[name]):
                positions[first + k] = q
            for k, rate in modal_values(name, "modal_rates", body, packages[name]):
                velocities[j + 6 + k], given[j + 6 + k] = rate, True
    return Start(positions, velocities, given)
