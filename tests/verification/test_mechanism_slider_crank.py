"""The flexible slider crank of the Test Set for IVP Solvers: motion, vibration, forces."""

import numpy as np
import pytest
from samples.flexible_samples import simulate

from plymotion.solver.dynamics.analysis.recovery import Recording
from plymotion.solver.inputs.case.tables.signals import ReactionSignal
from plymotion.solver.math import laws
from plymotion.solver.math.rotations import frame_from_axis
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import BuiltJoint, Start
from plymotion.solver.mechanism.consistent import consistent_state
from plymotion.solver.mechanism.tables import Body, JointTable, MarkerTable, rigid_body
from plymotion.solver.package.body.package_schema import Invariants
from plymotion.solver.signals.joints import joint_coordinate, reaction

X, Z = (frame_from_axis(np.array(a)) for a in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
ORIGIN = np.zeros(3)


REFERENCE = "ivp_slider_crank"


def _rod(data) -> Body:
    """The rod with the shapes of the problem, its frame between its ends."""
    m, L, pi = data["mass_rod"], data["rod"], np.pi
    along, across = np.zeros((2, 2)), np.zeros((2, 2))
    along[:] = [[8.0, 1.0], [1.0, 2.0]]  # as published
    across[:] = [[0.5, 0.0], [0.0, 0.5]]
    S, T01, T11 = np.zeros((3, 4)), np.zeros((3, 3, 4)), np.zeros((3, 3, 4, 4))
    S[0, 2:], S[1, 0] = [2 / 3, 1 / 6], 2 / pi
    T01[0, 0, 2:], T01[0, 1, :2] = [L / 3, L / 6], [L / pi, -L / (2 * pi)]
    T11[0, 0, 2:, 2:], T11[1, 1, :2, :2] = along, across
    T11[0, 1, 2, 0], T11[0, 1, 3, 0] = 16 / pi**3, 1 / pi - 8 / pi**3
    T11[0, 1, 3, 1] = -1 / (2 * pi)
    T11[1, 0] = T11[0, 1].T
    mass = m * (T11[0, 0] + T11[1, 1])
    A, h = data["side"] ** 2, data["side"]
    K = np.zeros((4, 4))
    K[0, 0], K[1, 1] = pi**4 / 24 * (h / L) ** 2, pi**4 * 2 / 3 * (h / L) ** 2
    K[2:, 2:] = [[16 / 3, -8 / 3], [-8 / 3, 7 / 3]]
    K *= data["E"] * A / L
    invariants = Invariants(
        mass=m,
        S0_B=m * np.array([L / 2, 0.0, 0.0]),
        S_B=m * S,
        T00_B=m * np.diag([L**2 / 3, 0.0, 0.0]),
        T01_B=m * T01,
        T11_B=m * T11,
        J0_B=(data["inertia_rod"] - m * L**2 / 3) * np.eye(3),
        J_psi_B=np.zeros((3, 4)),
        mass_form="consistent",
    )
    return Body("rod", invariants, mass, K, np.zeros((4, 4)))


def _model(data):
    none = np.zeros((3, 4))
    tip = none.copy()
    tip[0, 3] = 1.0
    bodies = [
        rigid_body("crank", 0.36, np.array([0.075, 0, 0]), 1e-3 * np.eye(3)),
        _rod(data),
        rigid_body("slider", data["mass_slider"], ORIGIN, 1e-4 * np.eye(3)),
    ]
    markers = [
        MarkerTable(-1, ORIGIN, Z),
        MarkerTable(0, ORIGIN, Z),
        MarkerTable(0, np.array([data["crank"], 0, 0]), Z),
        MarkerTable(1, ORIGIN, Z, none, none),
        MarkerTable(2, ORIGIN, Z),
        MarkerTable(1, np.array([data["rod"], 0, 0]), Z, tip, none),
        MarkerTable(-1, ORIGIN, X),
        MarkerTable(2, ORIGIN, X),
    ]
    joints = [
        JointTable("crank", "revolute", 0, 1),
        JointTable("crank (drive)", "rotation_drive", 0, 1, laws.polynomial([0, data["speed"]])),
        JointTable("pin", "revolute", 2, 3),
        JointTable("end", "point_on_line", 4, 5),
        JointTable("guide", "prismatic", 6, 7),
    ]
    return assemble_model(bodies, markers, joints, alpha=0.0, beta=0.0), joints


def _start(model, data):
    phi, phi_d = data["position_start"], data["velocity_start"]
    p, v = np.zeros(model.n_pos), np.zeros(model.n_vel)
    for i in range(3):
        p[model.pos_start[i] + 3] = 1.0
    p[model.pos_start[1]] = data["crank"]
    a, j = model.pos_start[1], model.vel_start[1]
    p[a + 7 : a + 11] = phi[3:]
    v[j + 6 : j + 10] = phi_d[3:]
    given = np.zeros(model.n_vel, dtype=bool)
    given[j + 6 : j + 10] = True
    p[model.pos_start[2]] = phi[2]
    return Start(p, v, given)


@pytest.fixture(scope="module")
def motion(reference):
    model, joints = _model(reference)
    y0 = consistent_state(model, _start(model, reference), [j.name for j in joints])
    times = np.linspace(0.0, reference["t_end"], 51)
    return model, Recording(model, times, simulate(model, y0, times, rtol=1e-11))


def _joint(kind, *rows, shift=ORIGIN):
    return BuiltJoint(kind, rows, shift)


def test_motion(reference, motion):
    model, recording = motion
    q, q_d = reference["position"], reference["velocity"]
    y = recording.y[-1]
    v = y[model.n_pos :]
    crank = joint_coordinate(_joint("revolute", 0, 1), "angle")(recording)[-1]
    pin = joint_coordinate(_joint("revolute", 2), "angle")(recording)[-1]
    assert crank == pytest.approx(q[0], abs=1e-9)  # 2.4 turns
    assert crank + pin == pytest.approx(q[1], abs=1e-7)
    assert joint_coordinate(_joint("prismatic", 4), "z")(recording)[-1] == pytest.approx(
        q[2], abs=1e-8
    )
    assert v[model.vel_start[1] + 5] == pytest.approx(q_d[1], abs=1e-5)
    assert v[model.vel_start[2]] == pytest.approx(q_d[2], abs=1e-6)


def test_vibration(reference, motion):
    model, recording = motion
    q = recording.modes(1)[-1]
    rates = recording.y[-1, model.n_pos + model.vel_start[1] + 6 :][:4]
    scale = np.abs(recording.modes(1)).max(axis=0)
    np.testing.assert_array_less(np.abs(q - reference["position"][3:]), 1e-4 * scale)
    np.testing.assert_allclose(rates, reference["velocity"][3:], atol=2e-5)


def test_forces(reference, motion):
    """Guide, pin and drive against the published multipliers."""
    _, recording = motion
    rod_end, slider, drive = reference["multipliers"]

    def force(joint, **table):
        keys = {"kind": "reaction", "joint": "any", "component": "x", "quantity": "force", **table}
        return reaction(joint, ReactionSignal(**keys))(recording)[-1]

    end = force(_joint("point_on_line", 3))
    # the published multipliers act with a minus on rod's end and slider
    np.testing.assert_allclose(end, [slider, -rod_end, 0.0], atol=2e-3)
    np.testing.assert_allclose(force(_joint("point_on_line", 3), side=1), -end, atol=1e-12)
    torque = force(_joint("revolute", 0, 1), quantity="moment")
    assert torque[2] == pytest.approx(-drive, abs=1e-3)
    acceleration = recording.acceleration(7)[-1]
    assert acceleration[0] == pytest.approx(reference["slider_acceleration"], rel=2e-5)
