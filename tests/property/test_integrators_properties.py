"""Properties that hold for any steps, any linear system, any output times."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from samples.constraint_runs import new_generic
from scipy.linalg import expm
from scipy_integrators import SCIPY

from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.generic.gear import (
    corrector,
    error_weights,
    interpolation,
    predictor,
)
from plymotion.solver.integrators.table import FOR_EQUATIONS

RATIOS = st.lists(st.floats(0.3, 3.0), min_size=1, max_size=5)
NAMES = st.sampled_from(sorted(FOR_EQUATIONS | SCIPY))


def distances(ratios):
    """Distances of past points from the new one; the first is 1."""
    return list(1 + np.concatenate(([0.0], np.cumsum(ratios))))


@given(RATIOS)
def test_formulae_are_exact_for_polynomials_on_any_steps(ratios):
    s = distances(ratios)
    k = len(s)
    c_0, b = corrector(s)
    for degree in range(k + 1):
        past = [(1 - s_i) ** degree for s_i in s]  # p(x) = x^degree, x = 1 at the new point
        derivative = c_0 * (1 - np.dot(b, past))
        assert abs(derivative - degree) < 1e-9 * max(map(abs, past)) * k * c_0 + 1e-9
        if degree < k:
            weights = predictor(s)
            assert abs(np.dot(weights, past) - 1) < 1e-10 * np.abs(weights) @ np.abs(past) + 1e-10


@given(RATIOS)
def test_error_weights_see_the_next_power_only(ratios):
    """Order k: nothing for degree k, h times the defect of the formula for degree k + 1."""
    s = distances(ratios)
    k = len(s) - 1
    weights = np.array(error_weights(s))
    x = np.concatenate(([0.0], -np.array(s)))
    size = np.abs(weights) @ np.abs(x) ** k
    assert abs(weights @ x**k) < 1e-10 * size
    c_0, b = corrector(s[:k])
    defect = -(0.0 - c_0 * (0.0 - np.dot(b, (-np.array(s[:k])) ** (k + 1))))
    assert abs(weights @ x ** (k + 1) + defect) < 1e-8 * (abs(defect) + size)


@given(RATIOS, st.integers(0, 5))
def test_interpolation_reproduces_the_points(ratios, which):
    points = [-p for p in distances(ratios)]
    which = which % len(points)
    weights = interpolation(points[which], points)
    np.testing.assert_allclose(weights, np.eye(len(points))[which], atol=1e-12)


@settings(max_examples=25, deadline=None)
@given(NAMES, st.integers(0, 2**32 - 1), st.lists(st.floats(0.01, 0.99), min_size=1, max_size=8))
def test_linear_systems_meet_the_matrix_exponential(name, seed, where):
    random = np.random.default_rng(seed)
    A = random.normal(size=(4, 4))
    y0 = random.normal(size=4)
    t = np.unique(np.array([*where, 1.0]))
    integrator = new_generic(name, lambda t, y: A @ y, 0.0, y0, 1.0, rtol=1e-7, atol=1e-9)
    solution = integrate(integrator, t)
    assert solution.status == "finished"
    exact = np.array([expm(A * t_i) @ y0 for t_i in t])
    scale = np.abs(exact).max() * np.exp(np.linalg.norm(A, 2))
    np.testing.assert_allclose(solution.y, exact, atol=2e-5 * scale)


@settings(max_examples=25, deadline=None)
@given(NAMES, st.floats(1e-3, 1e3))
def test_the_unit_of_time_does_not_matter(name, unit):
    """The same motion on a stretched time axis takes the same steps."""

    def steps(scale):
        integrator = new_generic(
            name,
            lambda t, y: np.array([y[1], -np.sin(y[0])]) / scale,
            0.0,
            np.array([1.0, 0.0]),
            6.0 * scale,
            rtol=1e-6,
            atol=1e-8,
            first_step=1e-3 * scale,
        )
        solution = integrate(integrator, [6.0 * scale])
        return solution.counters.steps, solution.y[-1]

    n_plain, y_plain = steps(1.0)
    n_scaled, y_scaled = steps(unit)
    assert abs(n_plain - n_scaled) <= 0.05 * n_plain + 1
    np.testing.assert_allclose(y_plain, y_scaled, atol=1e-4)
