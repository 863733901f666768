"""The equations of one flexible body against physics; decides the misprints of Eqs. (2), (7), (12).

Judge: with no load a body keeps energy, linear and angular momentum.
"""

import numpy as np
import pytest
from samples.flexible_samples import (
    body_of,
    momenta,
    point_by_point,
    random_points,
    random_state,
    simulate,
    total_energy,
)

from plymotion.solver.dynamics.evaluation.accelerations import assemble, derivative
from plymotion.solver.mechanism.assembly import assemble_model

TIMES = np.linspace(0.0, 1.0, 11)


@pytest.fixture(scope="module")
def spinning():
    """A free body that spins at about 5 rad/s while it vibrates at about 20 rad/s."""
    rng = np.random.default_rng(3)
    points = random_points(rng, 4)
    model = assemble_model([body_of(points)], [], [])
    y = random_state(rng, model, elastic=0.1)
    y[14:17] *= 3.0
    return points, model, y


@pytest.mark.parametrize("n_mode", [0, 1, 4])
def test_invariants_equal_the_sum_over_points(n_mode):
    """Eq. (2), (6), (7): two routes to one mass matrix and one right-hand side."""
    rng = np.random.default_rng(n_mode)
    points = random_points(rng, n_mode)
    gravity = np.array([0.3, -9.81, 0.2])
    body = body_of(points)
    model = assemble_model([body], [], [], gravity_G=gravity)
    y = random_state(rng, model)
    M, f = point_by_point(points, body.stiffness, y, gravity)
    equations = assemble(model, 0.0, y)
    np.testing.assert_allclose(equations.M, M, atol=1e-12 * np.abs(M).max())
    np.testing.assert_allclose(equations.f, f, atol=1e-12 * np.abs(f).max())


def test_free_body_keeps_energy_and_momenta(spinning):
    """Eq. (2), (7), (12): the three conservation laws to 1e-8 over 1 s."""
    _, model, y0 = spinning
    y = simulate(model, y0, TIMES)
    energy = np.array([total_energy(model, state) for state in y])
    linear, angular = (np.array(part) for part in zip(*(momenta(model, s) for s in y), strict=True))
    assert np.ptp(y[:, 7]) > 0.05, "the body must vibrate for the test to mean anything"
    assert np.abs(energy / energy[0] - 1).max() < 1e-8
    assert np.abs(linear - linear[0]).max() < 1e-8 * np.linalg.norm(linear[0])
    assert np.abs(angular - angular[0]).max() < 1e-8 * np.linalg.norm(angular[0])


def _coriolis_moment(points, y, m):
    """The third term of the paper's second row in Eq. (7): - sum m w~ b~ ddot."""
    q, w, q_d = y[7 : 7 + m], y[10 + m : 13 + m], y[13 + m : 13 + 2 * m]
    b, d = points.x + points.phi @ q, points.phi @ q_d
    return -np.cross(w, np.einsum("k,ka->a", points.m, np.cross(b, d)))


def test_printed_eq_7_loses_angular_momentum_though_not_energy(spinning):
    """Eq. (7) as printed counts the Coriolis moment twice: only angular momentum tells."""
    points, model, y0 = spinning
    m = points.n_mode

    def printed(t, y):
        equations = assemble(model, t, y)
        f = equations.f.copy()
        f[3:6] += _coriolis_moment(points, y, m)
        rate = derivative(model, t, y).copy()
        rate[model.n_pos : -1] = np.linalg.solve(equations.M, f)
        return rate

    y = simulate(model, y0, TIMES, printed)
    energy = np.array([total_energy(model, state) for state in y])
    angular = np.array([momenta(model, state)[1] for state in y])
    assert np.abs(energy / energy[0] - 1).max() < 1e-8
    assert np.abs(angular - angular[0]).max() > 1e-3 * np.linalg.norm(angular[0])


def test_printed_eq_7_without_rotary_gyroscopic_term_loses_angular_momentum(spinning):
    """Eq. (7) as printed lacks - w~ sum mu tdot."""
    points, model, y0 = spinning
    m = points.n_mode
    J_psi = np.einsum("kab,kbi->ai", points.J, points.psi)

    def printed(t, y):
        equations = assemble(model, t, y)
        f = equations.f.copy()
        f[3:6] += np.cross(y[10 + m : 13 + m], J_psi @ y[13 + m : 13 + 2 * m])
        rate = derivative(model, t, y).copy()
        rate[model.n_pos : -1] = np.linalg.solve(equations.M, f)
        return rate

    angular = np.array([momenta(model, s)[1] for s in simulate(model, y0, TIMES, printed)])
    assert np.abs(angular - angular[0]).max() > 1e-3 * np.linalg.norm(angular[0])


def test_printed_sign_of_s_in_eq_12_loses_energy(spinning):
    """Eq. (12), (14), (16) print -s after (7) already carries the minus."""
    points, model, y0 = spinning
    m = points.n_mode
    K = np.diag(400.0 * np.arange(1.0, m + 1.0))

    def printed(t, y):
        equations = assemble(model, t, y)
        load = np.concatenate([np.zeros(6), -K @ y[7 : 7 + m]])
        s = equations.f - load
        rate = derivative(model, t, y).copy()
        rate[model.n_pos : -1] = np.linalg.solve(equations.M, load - s)
        return rate

    energy = [total_energy(model, s) for s in simulate(model, y0, TIMES[:4], printed, rtol=1e-8)]
    assert abs(energy[-1] / energy[0] - 1) > 1e-2


def test_printed_sign_in_eq_2_makes_inertia_indefinite(spinning):
    """Eq. (2) prints M_ww with a minus in front of sum m b~' b~."""
    points, model, y0 = spinning
    M = assemble(model, 0.0, y0).M
    assert np.linalg.eigvalsh(M)[0] > 0
    rotary = points.J.sum(axis=0)
    printed = M.copy()
    printed[3:6, 3:6] = 2 * rotary - M[3:6, 3:6]
    assert np.linalg.eigvalsh(printed)[0] < 0


def test_free_fall_with_eccentric_deformation():
    """Gravity turns no freely falling body: its moment about the frame matters (Eq. (6))."""
    rng = np.random.default_rng(5)
    points = random_points(rng, 3)
    gravity = np.array([0.0, -9.81, 0.0])
    model = assemble_model([body_of(points)], [], [], gravity_G=gravity)
    y0 = np.zeros(model.n_pos + model.n_vel + 1)
    y0[3] = 1.0
    y0[7:10] = [0.2, -0.1, 0.15]  # released from a bent shape

    def centre(y):
        linear, _ = momenta(model, y)
        return linear / points.m.sum()

    y = simulate(model, y0, TIMES)
    for t, state in zip(TIMES, y, strict=True):
        np.testing.assert_allclose(centre(state), gravity * t, atol=1e-8 * 9.81)
    # Seen from its falling mass centre the body moves as it does without gravity.
    free = simulate(assemble_model([body_of(points)], [], []), y0, TIMES)
    np.testing.assert_allclose(y[:, 3:10], free[:, 3:10], atol=1e-8)
    assert np.ptp(y[:, 7]) > 0.05
