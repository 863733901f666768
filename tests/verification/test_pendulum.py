"""Pendulums: the rigid limit against the exact solution, and the same mass by two routes."""

import numpy as np
import pytest
from samples.flexible_samples import simulate, total_energy

from plymotion.solver.math import laws
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.consistent import consistent_state
from plymotion.solver.mechanism.tables import Body, JointTable, MarkerTable, rigid_body
from plymotion.solver.package import from_stations

NOTHING = np.zeros((3, 0))


REFERENCE = "a01_pendulum"


def _pendulum(body, gravity, *, phi=NOTHING, masses=()):
    """Hinge at the global origin; the rod lies along -x at the start."""
    n = phi.shape[1]
    markers = [
        MarkerTable(-1, np.zeros(3)),
        MarkerTable(0, np.zeros(3), np.eye(3), np.zeros((3, n)), np.zeros((3, n))),
        MarkerTable(0, np.array([-1.0, 0.0, 0.0]), np.eye(3), phi, np.zeros((3, n))),
    ]
    return assemble_model(
        [body], markers, [JointTable("hinge", "revolute", 0, 1)], masses, (0.0, -gravity, 0.0)
    )


def _at_rest(model):
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3] = 1.0
    return y


def _tip(model, y):
    from plymotion.solver.dynamics.elements.marker import marker_motion

    return np.array([marker_motion(model, 2, state).x for state in y])


@pytest.mark.parametrize("integrator", ["rk8", "gear"])
def test_rigid_pendulum_equals_the_exact_solution(reference, integrator):
    body = rigid_body("bob", 1.0, [-1.0, 0.0, 0.0], np.zeros((3, 3)))
    model = _pendulum(body, reference["gravity"])
    times = np.array([0.0] + [p["t"] for p in reference["positions"]])
    rtol = {"rk8": 1e-11, "gear": 1e-10}[integrator]
    y = simulate(model, _at_rest(model), times, rtol=rtol, name=integrator)
    for state, point in zip(_tip(model, y[1:]), reference["positions"], strict=True):
        error = np.hypot(state[0] - point["x"], state[1] - point["y"])
        assert error < reference["tolerance"]
        assert abs(state[2]) < 1e-12
    assert np.ptp([total_energy(model, s) for s in y]) < 5e-5  # the library's own target, J


def test_point_mass_equals_a_rigid_body(reference):
    """Mass at a marker (no unknowns) and mass of a body: the same pendulum."""
    bar = rigid_body("bar", 0.4, [-0.5, 0.0, 0.0], 0.03 * np.eye(3))
    tip = rigid_body("tip", 0.6, [0.0, 0.0, 0.0], 1e-12 * np.eye(3))
    carried = _pendulum(bar, 9.81, masses=[(2, 0.6)])
    markers = [
        MarkerTable(-1, np.zeros(3)),
        MarkerTable(0, np.zeros(3)),
        MarkerTable(0, np.array([-1.0, 0.0, 0.0])),
        MarkerTable(1, np.zeros(3)),
    ]
    joints = [JointTable("hinge", "revolute", 0, 1), JointTable("weld", "fixed", 2, 3)]
    joined = assemble_model([bar, tip], markers, joints, gravity_G=(0.0, -9.81, 0.0))
    y_joined = np.zeros(joined.n_pos + joined.n_vel + 1)
    y_joined[3] = y_joined[10] = 1.0
    y_joined[7] = -1.0
    times = np.linspace(0.0, 2.0, 9)
    one = _tip(carried, simulate(carried, _at_rest(carried), times))
    two = _tip(joined, simulate(joined, y_joined, times))
    np.testing.assert_allclose(one, two, atol=1e-8)


def _bar_with_one_mode(frequency):
    """A rod of two mass points whose free end swings across it at `frequency` [rad/s]."""
    m, x = np.array([0.4, 0.6]), np.array([[-0.5, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    phi = np.zeros((2, 3, 1))
    phi[:, 1, 0] = [0.3, 1.0]
    invariants = from_stations(m, x, phi, np.zeros((2, 3, 1)), np.zeros((2, 3, 3)), "lumped")
    mass = np.array([[np.sum(m * phi[:, 1, 0] ** 2)]])
    body = Body("rod", invariants, mass, frequency**2 * mass, np.zeros((1, 1)))
    return _pendulum(body, 9.81, phi=np.array([[0.0], [1.0], [0.0]]))


def test_flexible_pendulum_tends_to_the_rigid_one():
    """The distance to the rigid motion falls as one over the stiffness."""
    times = np.linspace(0.0, 1.0, 401)  # dense: the rod's vibration has any phase at few times
    rigid = rigid_body("rod", 1.0, [-0.8, 0.0, 0.0], np.diag([0.0, 0.06, 0.06]))
    model = _pendulum(rigid, 9.81)
    exact = simulate(model, _at_rest(model), times, rtol=1e-8)[:, 3:7]
    errors = []
    for frequency in (100.0, 200.0, 400.0):
        model = _bar_with_one_mode(frequency)
        y = simulate(model, _at_rest(model), times, rtol=1e-8)
        errors.append(np.abs(y[:, 3:7] - exact).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 2e-4
    assert np.all(rates > 1.6), (errors, rates)


def test_baumgarte_pulls_an_open_joint_together():
    """A violation decays critically damped with the time constant 1/alpha. Eq. (13)."""
    body = rigid_body("bob", 1.0, [-1.0, 0.0, 0.0], np.eye(3))
    model = _pendulum(body, 9.81)
    y = _at_rest(model)
    y[0] += 1e-3
    times = np.linspace(0.0, 2.0, 5)
    shift = np.linalg.norm(simulate(model, y, times)[:, 0:3], axis=1)
    expected = 1e-3 * (1 + 5.0 * times) * np.exp(-5.0 * times)
    np.testing.assert_allclose(shift, expected, rtol=1e-6)


def test_start_follows_from_a_drive():
    """Given nothing but a drive, positions and velocities fit it."""
    body = rigid_body("bar", 1.0, [0.5, 0.0, 0.0], 0.1 * np.eye(3))
    markers = [MarkerTable(-1, np.array([0.0, 0.2, 0.0])), MarkerTable(0, np.zeros(3))]
    joints = [
        JointTable("hinge", "revolute", 0, 1),
        JointTable("hinge (drive)", "rotation_drive", 0, 1, laws.polynomial([0.3, 2.0])),
    ]
    model = assemble_model([body], markers, joints)
    positions = np.array([0.01, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    start = Start(positions, np.zeros(6), np.zeros(6, dtype=bool))
    y = consistent_state(model, start, [j.name for j in joints])
    np.testing.assert_allclose(y[0:3], [0.0, 0.2, 0.0], atol=1e-11)
    np.testing.assert_allclose(2 * np.arctan2(y[6], y[3]), 0.3, atol=1e-11)
    np.testing.assert_allclose(y[10:13], [0.0, 0.0, 2.0], atol=1e-11)
