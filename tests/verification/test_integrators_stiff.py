"""Gear on stiff problems and the explicit methods, against SciPy's independent codes."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plymotion.solver.integrators.explicit import RungeKutta5, RungeKutta8
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.generic.gear import Gear


def van_der_pol(t, y):
    return np.array([y[1], 1000 * (1 - y[0] ** 2) * y[1] - y[0]])


def robertson(t, y):
    slow, fast, faster = 0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return np.array([fast - slow, slow - fast - faster, faster])


def robertson_jacobian(t, y):
    a, b, c = 1e4 * y[2], 1e4 * y[1], 6e7 * y[1]
    return np.array([[-0.04, a, b], [0.04, -a - c, -b], [0.0, c, 0.0]])


def double_pendulum(t, y):
    """Two equal bars without mass and two equal point masses; g = 9.81, lengths 1."""
    a, b, u, v = y
    c, s = np.cos(a - b), np.sin(a - b)
    M = np.array([[2, c], [c, 1]])
    right = np.array([-v * v * s - 19.62 * np.sin(a), u * u * s - 9.81 * np.sin(b)])
    return np.concatenate(([u, v], np.linalg.solve(M, right)))


def test_van_der_pol():
    t = np.linspace(0, 1500, 31)
    reference = solve_ivp(
        van_der_pol, (0, 1500), [2.0, 0.0], "LSODA", t_eval=t, rtol=1e-11, atol=1e-13
    ).y.T
    gear = Gear(van_der_pol, 0.0, np.array([2.0, 0.0]), 1500.0, rtol=1e-8, atol=1e-10)
    solution = integrate(gear, t)
    assert solution.status == "finished"
    np.testing.assert_allclose(solution.y[:, 0], reference[:, 0], atol=2e-5)
    assert solution.counters.steps < 3000  # explicit stability alone would need a million
    assert solution.counters.jacobians < solution.counters.steps / 20


@pytest.mark.parametrize("jacobian", [None, robertson_jacobian])
def test_robertson(jacobian):
    t = np.concatenate(([0.0], np.geomspace(0.04, 4e4, 25)))
    start = np.array([1.0, 0.0, 0.0])
    atol = np.array([1e-10, 1e-14, 1e-10])
    reference = solve_ivp(  # 5e-9 of SciPy's Radau with these tolerances, in a ninth of its time
        robertson, (0, 4e4), start, "LSODA", t_eval=t, rtol=1e-11, atol=atol / 100
    ).y.T
    gear = Gear(robertson, 0.0, start, 4e4, rtol=1e-7, atol=atol, jacobian=jacobian)
    solution = integrate(gear, t)
    assert solution.status == "finished"
    np.testing.assert_allclose(solution.y, reference, rtol=1e-5, atol=1e-10)
    np.testing.assert_allclose(solution.y.sum(axis=1), 1.0, rtol=1e-9)
    assert solution.counters.steps < 1500
    if jacobian is not None:
        without = solution.counters
        assert without.evaluations < 3 * without.steps


@pytest.mark.parametrize(("method", "scipy_name"), [(RungeKutta8, "DOP853"), (RungeKutta5, "RK45")])
def test_explicit_methods_agree_with_scipy(method, scipy_name):
    start, t = np.array([1.0, 1.5, 0.0, 0.0]), np.linspace(0, 3, 61)
    options = {"rtol": 1e-10, "atol": 1e-12}
    theirs = solve_ivp(double_pendulum, (0, 3), start, scipy_name, t_eval=t, **options)
    ours = integrate(method(double_pendulum, 0.0, start, 3.0, **options), t)
    np.testing.assert_allclose(ours.y, theirs.y.T, atol=2e-8)
    assert ours.counters.evaluations < 1.2 * theirs.nfev


def test_one_step_of_rk8_is_the_step_of_dop853():
    from scipy.integrate import DOP853

    start = np.array([1.0, 1.5, 0.0, 0.0])
    ours = RungeKutta8(double_pendulum, 0.0, start, 1.0, rtol=1e-6, first_step=0.05)
    theirs = DOP853(double_pendulum, 0.0, start, 1.0, rtol=1e-6, first_step=0.05)
    ours.step()
    theirs.step()
    assert ours.h == theirs.t - theirs.t_old
    np.testing.assert_allclose(ours.y, theirs.y, rtol=1e-14)
    t = np.linspace(ours.t_old, ours.t, 7)
    np.testing.assert_allclose(ours.dense_output()(t), theirs.dense_output()(t).T, rtol=1e-12)


@pytest.mark.parametrize("method", [RungeKutta5, RungeKutta8])
def test_stiffness_is_noticed_and_only_there(method):
    def decay(rate):
        return lambda t, y: np.array([-rate * (y[0] - np.cos(t))])

    stiff = integrate(method(decay(2000.0), 0.0, np.ones(1), 2.0), [2.0])
    assert stiff.status == "finished"
    assert len(stiff.hints) == 1
    assert "gear" in stiff.hints[0]
    assert not integrate(method(decay(1.0), 0.0, np.ones(1), 20.0), [20.0]).hints
