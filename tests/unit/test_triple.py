"""Vectors as tuples, and markers' motions as rows, against NumPy and matrices."""

import numpy as np
import pytest
from samples.flexible_samples import random_mechanism, random_state

from plymotion.solver.dynamics.elements.marker import marker_motion, single_motion
from plymotion.solver.dynamics.model import motion
from plymotion.solver.math.rotations import (
    about,
    column,
    cross3,
    dot3,
    minus3,
    put_column,
    skew,
    sum3,
    times3,
    triple,
    turned,
    turned_back,
    vector_to_matrix,
)
from plymotion.solver.math.rotations import tangent_coefficients as coefficients


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def test_products(rng):
    a, b, A = rng.normal(size=3), rng.normal(size=3), rng.normal(size=(3, 3))
    x, y = triple(a), triple(b)
    for found, expected in (
        (cross3(x, y), np.cross(a, b)),
        (dot3(x, y), a @ b),
        (sum3(x, y), a + b),
        (minus3(x, y), a - b),
        (times3(2.5, x), 2.5 * a),
        (turned(A, x), A @ a),
        (turned_back(A, x), A.T @ a),
        (column(A, 1), A[:, 1]),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-15, atol=1e-15)
    out = np.zeros((5, 2))
    put_column(out, 1, 1, x)
    np.testing.assert_array_equal(out[1:4, 1], a)
    assert np.count_nonzero(out) == 3


@pytest.mark.parametrize("size", [1e-3, 0.5, 2.5])
def test_about_a_vector_turns_as_the_matrices_do(rng, size):
    """exp(v~) x and T(v) x, without the matrices."""
    v, x = size * rng.normal(size=3), rng.normal(size=3)
    s = v @ v
    a, b, _, _ = coefficients(s)
    turned_x = about(triple(v), 1.0 - s * a, 1.0 - s * b, a, triple(x))
    np.testing.assert_allclose(turned_x, vector_to_matrix(v) @ x, rtol=0.0, atol=1e-14)
    T = (1.0 - s * b) * np.eye(3) + a * skew(v) + b * np.outer(v, v)
    mapped = about(triple(v), 1.0 - s * b, a, b, triple(x))
    np.testing.assert_allclose(mapped, T @ x, rtol=0.0, atol=1e-14)
    any_sum = (2.0 * np.eye(3) + 3.0 * skew(v) + 4.0 * np.outer(v, v)) @ x
    np.testing.assert_allclose(about(triple(v), 2.0, 3.0, 4.0, triple(x)), any_sum, rtol=1e-13)


def test_rows_of_motion_read_as_the_marker(rng):
    model = random_mechanism(8, 1)
    y = random_state(rng, model)
    for k in range(model.marker_body.size):
        row, J_m = single_motion(model, k, y)
        marker = marker_motion(model, k, y)
        for found, expected in (
            (motion.place(row), marker.x),
            (motion.velocity(row), marker.v),
            (motion.spin(row), marker.w),
            (motion.acceleration(row), marker.a),
            (motion.spin_rate(row), marker.alpha),
            (motion.axis(row, 1), marker.A[:, 1]),
        ):
            np.testing.assert_array_equal(found, expected)
        np.testing.assert_allclose(marker.A @ marker.A.T, np.eye(3), atol=1e-14)
        b = rng.normal(size=3)
        np.testing.assert_allclose(motion.from_axes(row, triple(b)), marker.A @ b, atol=1e-15)
        np.testing.assert_allclose(motion.in_axes(row, triple(b)), marker.A.T @ b, atol=1e-15)
        body = model.marker_body[k]
        if body >= 0:
            j = model.n_pos + model.vel_start[body]
            velocities = y[j : j + 6 + model.n_mode[body]]
            both = np.concatenate([marker.v, marker.w])
            np.testing.assert_allclose(J_m @ velocities, both, rtol=0.0, atol=1e-13)
