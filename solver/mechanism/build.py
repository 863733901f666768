"""Build the model of a mechanism, with its names and its start.

Virtual bodies are rigid bodies that constraints fix to an interface of a body.
Massless ones stand between an interface of a flexible body and its joints.

The paper (section 2.2) writes joints between rigid bodies only. Six constraints fix a virtual body
to the interface, and the joint is attached to the virtual body. A marker has the same six
equations substituted (solver/dynamics/elements/marker.py), so both give the same motion. A
virtual body has twelve more unknowns for every interface: six coordinates and six multipliers.

The mass matrix is then singular, but the saddle-point matrix is not: the motion of a virtual body
follows from its flexible body by the six constraints, and M is positive definite on all motions
that the constraints allow.

A point mass that is much heavier than its body is a virtual body as well. As a part of the body it
would be in its mass matrix, which turns with the body's frame: Newton's matrix of an implicit step,
frozen at one orientation, then misses the mass ratio times the rotation within the step, and the
iteration diverges. The force between the body and the virtual body is an unknown of the iteration.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from itertools import compress
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.model.model import GROUND, Model
from ..errors import InputError, nearest
from ..inputs.case.expressions import joint_starts
from ..math.arrays import Array
from ..math.records import record
from ..math.rotations import matrix_to_parameters, vector_to_matrix
from ..package import ModalPackage
from ..package.body.selection import rigid, selected
from .assembly import assemble_model
from .built_mechanism import BuiltMechanism, Start, frame_marker
from .case_tables import Reader, coupling_rows, force_tables, joint_tables, wind_laws
from .consistent import assembled
from .places import Places
from .tables import Body, JointTable, MarkerTable, flexible_body, rigid_body
from .tolerances import HEAVY_POINT_MASS

if TYPE_CHECKING:
    from ..inputs.case.tables.bodies import Deformed
    from ..inputs.case.tables.schema import Mechanism


@record
class VirtualBodies:
    """Tables of a mechanism, with virtual bodies after the others."""

    bodies: list[Body]  # the virtual ones
    markers: list[MarkerTable]  # all; those of the mechanism keep their numbers
    joints: list[JointTable]  # all; those of the mechanism keep their numbers
    carriers: list[tuple[int, Array]] = field(default_factory=list)  # body, position (3,) in it [m]

    def frames(self, r: Array, A: Array) -> list[tuple[Array, Array]]:
        """Return the positions of the virtual bodies for frames r (nb, 3), A (nb, 3, 3) at rest."""
        return [(r[body] + A[body] @ x, A[body]) for body, x in self.carriers]

    def scaled(self, model: Model) -> Model:
        """Return the model with the inertia of the carriers as scale of the virtual bodies."""
        if not self.carriers:
            return model
        scale = model.inertia_scale.copy()
        first = model.n_body - len(self.carriers)
        for k, (body, _) in enumerate(self.carriers):
            i, j = int(model.vel_start[body]), int(model.vel_start[first + k])
            if model.mass[first + k] == 0.0:
                scale[j : j + 3] = scale[i : i + 3]
            scale[j + 3 : j + 6] = scale[i + 3 : i + 6]
        return model._replace(inertia_scale=scale)

    def with_masses(
        self, bodies: Sequence[Body], names: Sequence[str], masses: Sequence[tuple[int, float]]
    ) -> "VirtualBodies":
        """Return the tables with each mass (marker, [kg]) as a virtual body, fixed to its marker.

        `bodies` are those of the mechanism without virtual ones.

        Parameters
        ----------
        bodies : bodies of the mechanism without virtual ones
        names : names of the mass points
        masses : marker and mass [kg] of each
        """
        result = VirtualBodies([*self.bodies], [*self.markers], [*self.joints], [*self.carriers])
        for name, (k, mass) in zip(names, masses, strict=True):
            result.add(name, mass, self.markers[k], len(bodies) + len(result.bodies))
        return result

    def add(self, name: str, mass: float, marker: MarkerTable, number: int) -> None:
        """Append a virtual body of a mass [kg], body `number` of the model, fixed to a marker.

        Parameters
        ----------
        name : name of the body and of the joint that fixes it
        mass : mass [kg], 0 of a massless one
        marker : marker at the interface
        number : number of the body in the model
        """
        self.bodies.append(rigid_body(name, mass, np.zeros(3), np.zeros((3, 3))))
        self.carriers.append((marker.body, marker.x))
        self.markers.extend([replace(marker, A=np.eye(3)), MarkerTable(number, np.zeros(3))])
        last = len(self.markers) - 1
        self.joints.append(JointTable(name, "fixed", last - 1, last))


def through_virtual_bodies(
    bodies: Sequence[Body], markers: Sequence[MarkerTable], joints: Sequence[JointTable]
) -> VirtualBodies:
    """Return the tables with every joint end on a flexible body moved to a virtual body.

    All joints of one interface share a virtual body, as in section 2.2 of the paper.

    Parameters
    ----------
    bodies : bodies of the mechanism
    markers : its markers
    joints : its joints and drives
    """
    virtual = VirtualBodies([], [*markers], [])
    number: dict[tuple[int, bytes, bytes], int] = {}  # interface -> its virtual body
    moved: dict[int, int] = {}  # marker on a flexible body -> marker on its virtual body

    def on_virtual_body(k: int) -> int:
        marker = markers[k]
        if marker.body == GROUND or not bodies[marker.body].mass.size:
            return k
        if k not in moved:
            interface = (marker.body, marker.x.tobytes(), marker.phi.tobytes())
            if interface not in number:
                number[interface] = len(bodies) + len(virtual.bodies)
                name = f"{bodies[marker.body].name} (virtual {len(virtual.bodies) + 1})"
                virtual.add(name, 0.0, marker, number[interface])
            virtual.markers.append(MarkerTable(number[interface], np.zeros(3), marker.A))
            moved[k] = len(virtual.markers) - 1
        return moved[k]

    own = [
        j._replace(marker_1=on_virtual_body(j.marker_1), marker_2=on_virtual_body(j.marker_2))
        for j in joints
    ]
    return replace(virtual, joints=own + virtual.joints)


def used_packages(
    mechanism: "Mechanism", packages: Mapping[str, ModalPackage]
) -> dict[str, ModalPackage]:
    """Return the packages by body, with the modes that the run uses.

    Raises
    ------
    PackageError
        A package without a mode or an interface that `reduced` asks for.
    """
    used = dict(packages)
    for name, body in mechanism.bodies.items():
        if body.kind == "rigid":
            continue
        if body.rigid:
            used[name] = rigid(used[name])
        elif body.reduced is not None:
            tables = [dict(vars(mode)) for mode in body.reduced]
            used[name] = selected(used[name], tables)
    return used


def modal_values(
    name: str, key: str, body: "Deformed", package: ModalPackage
) -> list[tuple[int, float]]:
    """Return the modes and their values of bodies.NAME.KEY (`modal_coordinates`, `modal_rates`).

    Modes have their labels, or their kinds if there is one of a kind, or numbers from 1. A body
    that the run takes as rigid has none.

    Parameters
    ----------
    name : name of the body
    key : `modal_coordinates` or `modal_rates`
    body : its table in the case
    package : its modal package

    Raises
    ------
    InputError
        No such mode; the same mode twice.
    """
    if getattr(body, "rigid", False):
        return []
    labels = list(package.mode_labels or package.mode_kinds)
    known = {label: k for k, label in enumerate(labels) if labels.count(label) == 1}
    known |= {str(k + 1): k for k in range(package.n_mode)}
    values: dict[int, float] = {}
    for word, value in getattr(body, key).items():
        where = f'bodies.{name}.{key} = "{word}"'
        if word not in known:
            raise InputError(f"{where}: no such mode{nearest(word, known)}")
        if known[word] in values:
            raise InputError(f"{where}: expected each mode once; it has another value")
        values[known[word]] = value
    return list(values.items())


MODERATE = 100.0  # mass point over its body: far from round-off


def build(
    mechanism: "Mechanism",
    packages: dict[str, ModalPackage],
    *,
    stiffening: bool = False,
    heaviest: float = np.inf,
    share: float = 0.0,
    everywhere: bool = False,
) -> BuiltMechanism:
    """Build the model of a checked mechanism (inputs/case/tables/schema.py).

    `stiffening` gives every body its second-order terms whatever the mechanism says; `heaviest` is
    the largest ratio of a mass point to its body, heavier ones are taken as so heavy. With a
    `share` joints are held at this share of their coordinates at the start. `everywhere` gives
    every place a marker with global axes at the start.

    Parameters
    ----------
    mechanism : tables of the case, checked
    packages : modal packages of the bodies by name
    stiffening : second-order terms for every body, whatever the case says
    heaviest : largest ratio of a mass point to its body; heavier ones count as so heavy
    share : joints are held at this share of their coordinates at the start
    everywhere : a marker with global axes for every place

    Raises
    ------
    InputError
        A package has no such interface; a distance joint has length zero.
    """
    places = Places(mechanism, packages)
    stiffening = stiffening or mechanism.solver.geometric_stiffening
    bodies = _bodies(mechanism, packages, stiffening=stiffening)
    joints, built_joints = joint_tables(mechanism, places, share)
    reader = Reader(mechanism, places, built_joints, joints)
    reader.states()
    forces = force_tables(mechanism, places, reader)
    reader.found.couplings += coupling_rows(mechanism, reader)
    rotor = None
    if mechanism.rotor is not None:
        from .rotor import rotor_table  # few mechanisms have one

        winds = wind_laws(mechanism, mechanism.rotor.wind)
        rotor = rotor_table(mechanism.rotor, winds, places, reader.found)
    masses = [
        (places.marker(f"masses.{name}.at", mass.at, np.eye(3)), mass.mass)
        for name, mass in mechanism.masses.items()
    ]
    own = [bodies[places.markers[k].body].invariants.mass for k, _ in masses]
    heavy = [0.0 < HEAVY_POINT_MASS * body < m for (_, m), body in zip(masses, own, strict=True)]
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
    markers = {at: places.marker("", at, np.eye(3)) for at in places.known if everywhere}
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
        rotor=rotor,
    )
    model = model._replace(quantities=model.quantities._replace(end=mechanism.solver.t_end))
    start = _start(mechanism, places, virtual, model, packages)
    return BuiltMechanism(
        model=virtual.scaled(model),
        start=start if share else _joints_started(mechanism, packages, start),
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
        markers=markers,
    )


TURN = 0.5  # [rad] of a step to the start of a joint: Newton's method stays at its root


def _joints_started(
    mechanism: "Mechanism", packages: dict[str, ModalPackage], start: Start
) -> Start:
    """Return the start with bodies moved to the given coordinates of joints."""
    values = [v for joint in mechanism.joints.values() for v in joint_starts(joint).values()]
    steps = ceil(max(map(abs, values)) / TURN) if any(values) else 0
    for step in range(1, steps + 1):
        held = build(mechanism, packages, share=step / steps)
        start = start._replace(positions=assembled(held.model, start, held.joint_names))
    return start


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
