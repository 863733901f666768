"""Mechanisms of stiffened beams: a rotating beam linearised about its spin, the double pendulum."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from samples.beam_samples import Beam, reduced

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.dynamics.elements.marker import marker_motion
from plymotion.solver.dynamics.evaluation.accelerations import derivative
from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.math.laws import polynomial
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.consistent import consistent_state
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, flexible_body
from plymotion.solver.package import ModalPackage

GRAVITY = (0.0, -9.81, 0.0)


def rectangle(E: float, nu: float, rho: float, across: float, along: float):
    """6x6 stiffness and mass of a rectangle, `across` along the section's x2."""
    A, G = across * along, E / 2 / (1 + nu)
    I2, I3 = across * along**3 / 12, along * across**3 / 12
    K = np.diag([E * A, 5 / 6 * G * A, 5 / 6 * G * A, G * (I2 + I3), E * I2, E * I3])
    J = rho * np.diag([I2 + I3, I2, I3])
    return K, SectionMass(rho * A, np.zeros(3), J).matrix()


def on_interface(body: int, beam: Beam, name: str, *, stiffening: bool = True) -> MarkerTable:
    i = beam.interface(name)
    H = (i.H_B, i.H_psi_B) if stiffening else ()
    return MarkerTable(body, i.position_B, np.eye(3), i.phi_B, i.psi_B, *H)


def steady_spin(package: ModalPackage, spin: float, hub: float = 0.0, *, stiffening: bool = True):
    """Frequencies (k,), rising, and columns (m, k) of a clamped beam that spins about z.

    The solver's own accelerations, linearised about the bent and stretched state at rest in the
    rotating frame; `hub` is the distance of the root from the axis.
    """
    m = package.n_mode
    none, H = np.zeros((3, m)), np.zeros((3, m, m))
    markers = [
        MarkerTable(-1, np.zeros(3)),
        MarkerTable(0, np.array([-hub, 0.0, 0.0]), np.eye(3), none, none, H, H),
    ]
    joints = [
        JointTable("hub", "revolute", 0, 1),
        JointTable("drive", "rotation_drive", 0, 1, polynomial([0.0, spin])),
    ]
    body = flexible_body("beam", package, stiffening=stiffening)
    model = assemble_model([body], markers, joints, alpha=0.0, beta=0.0)

    def accelerations(q, q_d):
        y = np.zeros(model.n_pos + model.n_vel + 1)
        y[0], y[3], y[7 : 7 + m] = hub, 1.0, q
        j = model.n_pos
        y[j + 1], y[j + 5], y[j + 6 : j + 6 + m] = spin * hub, spin, q_d
        return derivative(model, 0.0, y)[j + 6 : j + 6 + m]

    def slope(f, x, step):
        return np.array([(f(x + step * e) - f(x - step * e)) / (2 * step) for e in np.eye(m)]).T

    q, still, step = np.zeros(m), np.zeros(m), 1e-5
    for _ in range(6):
        by_q = slope(lambda x: accelerations(x, still), q, step)
        q = q - np.linalg.solve(by_q, accelerations(q, still))
    by_q = slope(lambda x: accelerations(x, still), q, step)
    by_rate = slope(lambda x: accelerations(q, x), still, 1e-3)
    values, vectors = np.linalg.eig(np.block([[np.zeros((m, m)), np.eye(m)], [by_q, by_rate]]))
    assert np.abs(values.real).max() < 1e-6 * np.abs(values).max() or not stiffening
    kept = np.flatnonzero(values.imag > 1e-9)
    kept = kept[np.argsort(values.imag[kept])]
    return values.imag[kept], vectors[:m, kept]


@dataclass(frozen=True)
class Pendulum:
    """A soft double pendulum: model, consistent start, markers of the arm's middle and the tip."""

    model: Model
    y0: np.ndarray
    middle: int
    tip: int

    def place(self, marker: int, y: np.ndarray) -> np.ndarray:
        return marker_motion(self.model, marker, y).x


CHORD = {"kind": "chord", "at": ["root", "tip"]}
CLAMPED = {"kind": "clamped", "at": "root"}


def soft_modes(count: int, *, axial: bool = False, static: bool = True):
    modes = [{"kind": "bending-xy", "count": count}] if count else []
    if static:
        modes += [{"kind": "attachment", "at": at, "directions": ["rz"]} for at in ("root", "tip")]
    return [*modes, {"kind": "static-axial"}] if axial else modes


def soft_pendulum(reference, modes, *, arms: int = 1, elements: int = 24) -> Pendulum:
    """The variant `soft-free` of the paper's double pendulum; its arm in `arms` bodies."""
    arm = rectangle(73e9, 0.3, 2700.0, 0.015, 0.060)
    hand = rectangle(73e9, 0.3, 2700.0, 0.010, 0.040)
    links = [(arm, 0.545 / arms)] * arms + [(hand, 0.675)]
    beams = [
        reduced(reference, modes, elements=elements // arms, K=K, mass=mass, length=length)
        for (K, mass), length in links
    ]
    bodies = [flexible_body(f"{i}", b.package, stiffening=True) for i, b in enumerate(beams)]
    markers = [MarkerTable(-1, np.zeros(3))]
    ends = []
    for i, beam in enumerate(beams):
        markers += [on_interface(i, beam, name) for name in ("root", "mid", "tip")]
        ends.append(3 * i + 1)
    drive = polynomial([0.0, 20.0])
    joints = [
        JointTable("shoulder", "revolute", 0, 1),
        JointTable("drive", "rotation_drive", 0, 1, drive),
    ]
    for i, (one, two) in enumerate(pairwise(ends)):
        kind = "revolute" if i == arms - 1 else "fixed"
        joints.append(JointTable(f"joint {i}", kind, one + 2, two))
    elbow, tip = ends[arms - 1] + 2, ends[-1] + 2
    masses = [(elbow, 1.0), (tip, 3.0)]
    model = assemble_model(bodies, markers, joints, masses, GRAVITY)
    positions, velocities = np.zeros(model.n_pos), np.zeros(model.n_vel)
    given = np.ones(model.n_vel, dtype=bool)
    x = 0.0
    for i, (_, length) in enumerate(links):
        a, j = model.pos_start[i], model.vel_start[i]
        positions[a], positions[a + 3] = x, 1.0
        given[j : j + 3] = False
        velocities[j + 5] = 20.0 if i < arms else 0.0
        x += length
    names = [joint.name for joint in joints]
    y0 = consistent_state(model, Start(positions, velocities, given), names)
    return Pendulum(model, y0, ends[arms // 2] + (0 if arms % 2 == 0 else 1), tip)
