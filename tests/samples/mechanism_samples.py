"""Mechanisms of rigid rods for tests and benchmarks: chains, N-four-bar, Bricard, A01 pendulum.

A rod's frame stands at its middle with the global axes at the start; a point of a mechanism is
given by its global position at the start.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from plymotion.solver.dynamics.elements.marker import marker_motion
from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.math.rotations import frame_from_axis
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.tables import Body, JointTable, MarkerTable, rigid_body

GROUND = -1
Z = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Sample:
    """A mechanism, where it starts, and the marker whose motion is measured."""

    model: Model
    start: Start
    names: list[str]  # of the joints
    probe: int

    def place(self, y: np.ndarray) -> np.ndarray:
        """Global positions (k, 3) of the probe at states y (k, n)."""
        return np.array([marker_motion(self.model, self.probe, state).x for state in y])


@dataclass
class Rods:
    """Rods and hinges as they are added."""

    side: float = 0.0  # of a square section [m]
    core: float = 0.0  # more inertia about a rod's own axis; no part in a plane motion [kg m2]
    bodies: list[Body] = field(default_factory=list)
    centres: list[np.ndarray] = field(default_factory=list)
    markers: list[MarkerTable] = field(default_factory=list)
    joints: list[JointTable] = field(default_factory=list)

    def rod(self, start, end, mass: float = 1.0) -> int:
        a, b = np.array(start, dtype=float), np.array(end, dtype=float)
        length = np.linalg.norm(b - a)
        e = (b - a) / length
        along = mass * self.side**2 / 6.0 + self.core
        across = mass * (length**2 + self.side**2) / 12.0
        inertia = across * np.eye(3) + (along - across) * np.outer(e, e)
        self.bodies.append(rigid_body(f"rod {len(self.bodies)}", mass, np.zeros(3), inertia))
        self.centres.append(0.5 * (a + b))
        return len(self.bodies) - 1

    def marker(self, body: int, point, axis=Z) -> int:
        x = np.array(point, dtype=float) - (0.0 if body == GROUND else self.centres[body])
        self.markers.append(MarkerTable(body, x, frame_from_axis(np.array(axis, dtype=float))))
        return len(self.markers) - 1

    def joint(self, name: str, kind: str, one: int, two: int, point, axis=Z) -> None:
        k = self.marker(one, point, axis)
        self.joints.append(JointTable(name, kind, k, self.marker(two, point, axis)))

    def sample(self, probe: tuple[int, tuple], spins=None, **options) -> Sample:
        """`spins`: body -> angular velocity at the start; all other velocities follow."""
        at = self.marker(*probe)
        model = assemble_model(self.bodies, self.markers, self.joints, **options)
        positions, velocity = np.zeros(model.n_pos), np.zeros(model.n_vel)
        given = np.zeros(model.n_vel, dtype=bool)
        for i, centre in enumerate(self.centres):
            positions[7 * i : 7 * i + 3] = centre
            positions[7 * i + 3] = 1.0
        for i, spin in (spins or {}).items():
            velocity[6 * i + 3 : 6 * i + 6] = spin
            given[6 * i + 3 : 6 * i + 6] = True
        return Sample(model, Start(positions, velocity, given), [j.name for j in self.joints], at)


GRAVITY = (0.0, -9.81, 0.0)


def four_bars(n: int, misfit: float = 0.0, core: float = 0.0) -> Sample:
    """A02, the N-four-bar mechanism: n + 1 uprights, n couplers, singular when horizontal.

    All joints are hinges about z, so each loop also has three redundant equations. With a misfit
    [m] the last foot stands too far away: the branches no longer meet, they turn into each other.
    """
    rods = Rods(core=core)
    uprights = [rods.rod((i, 0, 0), (i, 1, 0)) for i in range(n + 1)]
    couplers = [rods.rod((i, 1, 0), (i + 1, 1, 0)) for i in range(n)]
    for i, upright in enumerate(uprights):
        away = misfit if i == n else 0.0
        k = rods.marker(GROUND, (i + away, 0, 0))
        rods.joints.append(JointTable(f"foot {i}", "revolute", k, rods.marker(upright, (i, 0, 0))))
    for i, coupler in enumerate(couplers):
        rods.joint(f"left {i}", "revolute", uprights[i], coupler, (i, 1, 0))
        rods.joint(f"right {i}", "revolute", uprights[i + 1], coupler, (i + 1, 1, 0))
    return rods.sample((uprights[0], (0, 1, 0)), {uprights[0]: (0, 0, -1.0)}, gravity_G=GRAVITY)


def bricard() -> Sample:
    """A04, Bricard's mechanism: as many equations as coordinates, one redundant, one freedom."""
    points = [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]
    axes = ["y", "z", "x", "y", "z", "x"]
    rods = Rods(side=0.1)
    bodies = [rods.rod(a, b) for a, b in pairwise(points)]
    links = [GROUND, *bodies, GROUND]
    for i, (point, axis) in enumerate(zip(points, axes, strict=True)):
        direction = np.eye(3)["xyz".index(axis)]
        rods.joint(f"joint {i + 1}", "revolute", links[i], links[i + 1], point, direction)
    return rods.sample((bodies[2], points[3]), gravity_G=GRAVITY)


def chain(n: int, kind: str = "revolute") -> Sample:
    """A hanging chain of n links of 1 m, released at rest from the horizontal; probe at its end.

    `kind` is that of every joint: "revolute" about z, or "spherical".
    """
    rods = Rods(side=0.1)
    links = [rods.rod((i, 0, 0), (i + 1, 0, 0)) for i in range(n)]
    for i, link in enumerate(links):
        rods.joint(f"hinge {i}", kind, links[i - 1] if i else GROUND, link, (i, 0, 0))
    return rods.sample((links[-1], (n, 0, 0)), gravity_G=GRAVITY)


def pendulum() -> Sample:
    """A01: a mass point of 1 kg at (-1, 0), kept 1 m away from the origin, released at rest.

    The body's frame stands at the mass, so that the distance is a constraint to be kept.
    """
    body = rigid_body("bob", 1.0, np.zeros(3), 0.1 * np.eye(3))
    markers = [MarkerTable(GROUND, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    joints = [JointTable("rod", "distance", 0, 1, parameters=(1.0,))]
    model = assemble_model([body], markers, joints, gravity_G=GRAVITY)
    positions = np.array([-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    start = Start(positions, np.zeros(6), np.zeros(6, dtype=bool))
    return Sample(model, start, ["rod"], 1)
