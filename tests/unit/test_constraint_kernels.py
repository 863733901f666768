"""The three solutions for accelerations and multipliers, on small matrices."""

import numpy as np
import pytest

from plymotion.solver.dynamics.elements.constraints.augmented_lagrangian import augmented_lagrangian
from plymotion.solver.dynamics.elements.constraints.baumgarte import stabilised
from plymotion.solver.dynamics.elements.constraints.minimum_norm import minimum_norm
from plymotion.solver.dynamics.elements.constraints.saddle_point import saddle_point
from plymotion.solver.dynamics.elements.constraints.treatment import row_masses, scaled_jacobian

N = 7


@pytest.fixture
def problem():
    rng = np.random.default_rng(4)
    half = rng.normal(size=(N, N))
    M = half @ half.T + N * np.eye(N)
    return M, rng.normal(size=N), rng.normal(size=(3, N)), rng.normal(size=3)


def penalised(M, f, Phi_q, gamma, scale, penalty=1e7, iterations=20):
    return augmented_lagrangian(M, f, Phi_q, gamma, scale, penalty, 1e-13, iterations)


def test_all_agree_on_independent_constraints(problem):
    M, f, Phi_q, gamma = problem
    scale = np.diag(M).copy()
    a, multipliers = saddle_point(M, f, Phi_q, gamma)
    np.testing.assert_allclose(M @ a + Phi_q.T @ multipliers, f, atol=1e-12)
    np.testing.assert_allclose(Phi_q @ a, gamma, atol=1e-12)
    for found in (minimum_norm(M, f, Phi_q, gamma, scale, 0), penalised(*problem, scale)):
        np.testing.assert_allclose(found[0], a, atol=1e-11)
        np.testing.assert_allclose(found[1], multipliers, atol=1e-10)


def redundant(problem):
    """Five rows of rank three: a copy and a sum of others."""
    M, f, Phi_q, gamma = problem
    mix = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 2, -1]])
    return M, f, mix @ Phi_q, mix @ gamma


def test_redundant_rows_change_no_motion_and_share_by_least_squares(problem):
    M, f, Phi_q, gamma = redundant(problem)
    scale = np.diag(M).copy()
    expected, _ = saddle_point(*problem)
    root = np.sqrt(row_masses(Phi_q, scale))
    force = f - M @ expected
    # independent route: least squares on the scaled rows
    least = root * np.linalg.lstsq((root[:, None] * Phi_q).T, force, rcond=1e-10)[0]
    found = minimum_norm(M, f, Phi_q, gamma, scale, 2)
    np.testing.assert_allclose(found[0], expected, atol=1e-11)
    np.testing.assert_allclose(found[1], least, atol=1e-10)
    found = penalised(M, f, Phi_q, gamma, scale)
    np.testing.assert_allclose(found[0], expected, atol=1e-11)
    np.testing.assert_allclose(found[1], least, atol=1e-9)


def test_values_that_are_zero_but_for_rounding_are_not_divided_by(problem):
    """A computed motion holds redundant rows to 1e-6 only: the count of them settles it."""
    M, f, Phi_q, gamma = redundant(problem)
    scale = np.diag(M).copy()
    rng = np.random.default_rng(1)
    off = Phi_q + 1e-6 * rng.normal(size=Phi_q.shape)
    expected, _ = saddle_point(*problem)
    gamma = gamma + np.array([0.0, 0.0, 0.0, 1e-3, 0.0])
    counted, _ = minimum_norm(M, f, off, gamma, scale, 2)
    uncounted, _ = minimum_norm(M, f, off, gamma, scale, 0)
    np.testing.assert_allclose(counted, expected, atol=2e-3)
    assert np.abs(uncounted).max() > 100.0


@pytest.mark.parametrize("solve", ["minimum_norm", "penalised"])
def test_units_do_not_matter(problem, solve):
    """Millimetres and grams: the same motion, the same decision on rank."""
    M, f, Phi_q, gamma = redundant(problem)
    rng = np.random.default_rng(2)
    columns = 10.0 ** rng.integers(-4, 5, size=N)  # units of coordinates
    rows = 10.0 ** rng.integers(-4, 5, size=5)  # units of constraints
    scale = np.diag(M).copy()
    given = M, f, Phi_q, gamma
    other = (
        M / np.outer(columns, columns),
        f / columns,
        rows[:, None] * Phi_q / columns,
        rows * gamma,
    )
    if solve == "minimum_norm":
        a, multipliers = minimum_norm(*given, scale, 0)
        b, others = minimum_norm(*other, scale / columns**2, 0)
    else:
        a, multipliers = penalised(*given, scale)
        b, others = penalised(*other, scale / columns**2)
    np.testing.assert_allclose(b / columns, a, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(others * rows, multipliers, rtol=1e-7, atol=1e-9)
    C = scaled_jacobian(Phi_q, scale)
    np.testing.assert_allclose(scaled_jacobian(other[2], scale / columns**2), C, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(C, axis=1), 1.0)


def test_bodies_without_inertia_are_held_by_their_constraints(problem):
    """A singular mass matrix whose null space the constraints take away."""
    M, f, Phi_q, gamma = problem
    M = M.copy()
    M[:, 0] = M[0] = 0.0
    scale = np.where(np.diag(M) > 0, np.diag(M), 1.0)
    a, multipliers = saddle_point(M, f, Phi_q, gamma)
    for found in (minimum_norm(M, f, Phi_q, gamma, scale, 0), penalised(M, f, Phi_q, gamma, scale)):
        np.testing.assert_allclose(found[0], a, atol=1e-10)
        np.testing.assert_allclose(found[1], multipliers, atol=1e-9)


def test_iteration_gains_by_the_penalty(problem):
    """The error shrinks by 1 + penalty sigma^2 at least in each iteration."""
    scale = np.diag(problem[0]).copy()
    exact, _ = saddle_point(*problem)
    sigma = np.linalg.svd(scaled_jacobian(problem[2], scale), compute_uv=False)[-1]
    errors = [
        np.linalg.norm(penalised(*problem, scale, penalty=30.0, iterations=k)[0] - exact)
        for k in (1, 2, 3, 4)
    ]
    assert np.all(np.array(errors[1:]) < np.array(errors[:-1]) / (1 + 0.5 * 30.0 * sigma**2))


def test_a_row_that_nothing_can_move_is_left_alone():
    M, f = np.eye(2), np.array([1.0, 2.0])
    Phi_q, gamma = np.array([[1.0, 0.0], [0.0, 0.0]]), np.zeros(2)
    assert row_masses(Phi_q, np.ones(2)).tolist() == [1.0, 0.0]
    for found in (
        minimum_norm(M, f, Phi_q, gamma, np.ones(2), 1),
        penalised(M, f, Phi_q, gamma, np.ones(2)),
    ):
        np.testing.assert_allclose(found[0], [0.0, 2.0], atol=1e-12)
        np.testing.assert_allclose(found[1], [1.0, 0.0], atol=1e-6)


def test_feedback():
    gamma = stabilised(np.array([1.0]), np.array([0.1]), np.array([0.2]), 3.0, 4.0)
    assert gamma[0] == pytest.approx(1.0 - 2 * 3.0 * 0.2 - 16.0 * 0.1)
