"""Static equilibrium against hand-worked positions and the minimum of the potential energy."""

import numpy as np
import pytest
from samples.flexible_samples import body_of, random_points
from scipy.optimize import brentq

from plymotion.solver.dynamics.elements.marker import marker_motion
from plymotion.solver.dynamics.evaluation.accelerations import accelerations, assemble
from plymotion.solver.errors import InputError
from plymotion.solver.math import laws
from plymotion.solver.math.rotations import frame_from_axis, matrix_to_parameters, vector_to_matrix
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.consistent import consistent_state
from plymotion.solver.mechanism.equilibrium import equilibrium
from plymotion.solver.mechanism.tables import ForceTable, JointTable, MarkerTable, rigid_body

GRAVITY = (0.0, -9.81, 0.0)


def _start(model, positions):
    """The frames of the bodies as (r, rotation vector); everything free, modes at zero."""
    p = np.zeros(model.n_pos)
    for i, (r, theta) in enumerate(positions):
        a = model.pos_start[i]
        p[a : a + 3] = r
        p[a + 3 : a + 7] = matrix_to_parameters(vector_to_matrix(np.array(theta, dtype=float)))
    return Start(p, np.zeros(model.n_vel), np.zeros(model.n_vel, dtype=bool))


def _settled(model, positions, names):
    start = _start(model, positions)
    y = consistent_state(model, start, [str(k) for k in range(len(model.joint_kind))])
    found = equilibrium(model, Start(y[: model.n_pos], start.velocities, start.given), names)
    y = np.concatenate([found.positions, np.zeros(model.n_vel + 1)])
    equations = assemble(model, 0.0, y)
    a, _ = accelerations(model, equations, y)
    assert np.abs(equations.Phi).max(initial=0.0) < 1e-11
    assert np.abs(a).max() < 1e-7  # it stays at rest
    return y


def _rod(gravity=GRAVITY, forces=(), centre=(0.5, 0.0, 0.0)):
    """A rod hinged at the origin about z."""
    body = rigid_body("rod", 2.0, np.array(centre), 0.1 * np.eye(3))
    markers = [
        MarkerTable(-1, np.zeros(3)),
        MarkerTable(0, np.zeros(3)),
        MarkerTable(0, np.array([1.0, 0.0, 0.0])),
        MarkerTable(-1, np.array([0.0, 1.0, 0.0])),
    ]
    joints = [JointTable("hinge", "revolute", 0, 1)]
    return assemble_model([body], markers, joints, gravity_G=gravity, forces=forces)


@pytest.mark.parametrize("angle", [0.0, 2.0, 0.5 * np.pi, -1.5])
def test_pendulum_hangs_whatever_its_start(angle):
    """Also from upright, where it would stay by the equations alone."""
    model = _rod()
    y = _settled(model, [((0, 0, 0), (0, 0, angle))], ["rod"])
    np.testing.assert_allclose(marker_motion(model, 2, y).x, [0.0, -1.0, 0.0], atol=1e-8)


def test_rod_on_a_spring():
    """The balance of moments of weight and spring, solved by itself."""
    k, length = 60.0, 0.8
    model = _rod(forces=[ForceTable("coil", "spring", 3, 2, (k, 0.0, length))])

    def moment(phi):
        tip = np.array([np.cos(phi), np.sin(phi)])
        d = tip - np.array([0.0, 1.0])
        s = np.linalg.norm(d)
        pull = -k * (s - length) * d / s
        return tip[0] * pull[1] - tip[1] * pull[0] - 2.0 * 9.81 * 0.5 * tip[0]

    expected = brentq(moment, 0.0, 1.0, xtol=1e-13)
    y = _settled(model, [((0, 0, 0), (0, 0, 0.1))], ["rod"])
    tip = marker_motion(model, 2, y).x
    assert np.arctan2(tip[1], tip[0]) == pytest.approx(expected, abs=1e-9)


def test_flexible_body_sags_as_its_modes_say():
    """Clamped: q = K^-1 (modal weight and load), linear and exact."""
    rng = np.random.default_rng(2)
    points = random_points(rng, 3)
    body = body_of(points)
    force = np.array([3.0, -1.0, 2.0])
    phi = 0.3 * rng.normal(size=(3, 3))
    none = np.zeros((3, 3))
    markers = [
        MarkerTable(-1, np.zeros(3)),
        MarkerTable(0, np.zeros(3), np.eye(3), none, none),
        MarkerTable(0, np.ones(3), np.eye(3), phi, none),
    ]
    size = float(np.linalg.norm(force))
    load = ForceTable("load", "force", 0, 2, tuple(force / size), laws.polynomial([size]))
    joints = [JointTable("clamp", "fixed", 0, 1)]
    model = assemble_model([body], markers, joints, gravity_G=GRAVITY, forces=[load])
    y = _settled(model, [((0, 0, 0), (0, 0, 0))], ["beam"])
    weight = np.einsum("k,kai,a->i", points.m, points.phi, np.array(GRAVITY))
    expected = np.linalg.solve(body.stiffness, weight + phi.T @ force)
    np.testing.assert_allclose(y[7:10], expected, rtol=1e-9)


def test_following_load():
    """A pendulum pushed across itself: m g l/2 sin(phi) = F l holds, F turning with the rod."""
    F = 4.0
    load = ForceTable("push", "force", 2, 2, (0.0, 1.0, 0.0), laws.polynomial([F]))
    model = _rod(forces=[load])
    y = _settled(model, [((0, 0, 0), (0, 0, -1.2))], ["rod"])
    tip = marker_motion(model, 2, y).x
    assert tip[0] == pytest.approx(F / (2.0 * 9.81 * 0.5), rel=1e-9)


def test_closed_loop_with_redundant_joints():
    """Three hinged rods under gravity rest where their potential energy is least."""
    rods = [rigid_body(n, 1.0, np.array([0.5, 0, 0]), 0.1 * np.eye(3)) for n in "abc"]
    markers, joints = [], []

    def hinge(name, one, x_one, two, x_two):
        A = frame_from_axis(np.array([0.0, 0.0, 1.0]))
        for body, x in ((one, x_one), (two, x_two)):
            markers.append(MarkerTable(body, np.array(x, dtype=float), A))
        joints.append(JointTable(name, "revolute", len(markers) - 2, len(markers) - 1))

    hinge("left", -1, (0, 0, 0), 0, (0, 0, 0))
    hinge("elbow", 0, (1, 0, 0), 1, (0, 0, 0))
    hinge("other", 1, (1, 0, 0), 2, (1, 0, 0))
    hinge("right", -1, (1.5, 0, 0), 2, (0, 0, 0))
    model = assemble_model(rods, markers, joints, gravity_G=GRAVITY)
    start = [((0, 0, 0), (0, 0, 1.2)), ((0.4, 0.9, 0), (0, 0, 0.1)), ((1.5, 0, 0), (0, 0, 1.8))]
    y = _settled(model, start, ["a", "b", "c"])
    # Symmetric: the uprights hang inwards below the ground points, the coupler is level.
    np.testing.assert_allclose(marker_motion(model, 2, y).x, [0.25, -np.sqrt(15) / 4, 0], atol=1e-8)
    np.testing.assert_allclose(marker_motion(model, 4, y).x, [1.25, -np.sqrt(15) / 4, 0], atol=1e-8)


def test_free_body_has_none():
    body = rigid_body("ball", 2.0, np.zeros(3), 0.1 * np.eye(3))
    model = assemble_model([body], [MarkerTable(0, np.zeros(3))], [], gravity_G=GRAVITY)
    with pytest.raises(
        InputError, match=r"no static equilibrium .* ball still has an unbalanced .* 9\.81"
    ):
        equilibrium(model, _start(model, [((0, 0, 0), (0, 0, 0))]), ["ball"])
