"""Rotations against SciPy's, and every rate against a difference."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from plymotion.solver.math import rotations
from plymotion.solver.math.rotations import tangent_rate

NUMBER = st.floats(-1.0, 1.0, allow_subnormal=False)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
ANGLE = st.floats(0.0, 3.0)
PARAMETERS = st.tuples(NUMBER, NUMBER, NUMBER, NUMBER).map(np.array)


def _difference(f, h=1e-4):
    """Fourth-order central difference at zero."""
    return (f(-2 * h) - 8 * f(-h) + 8 * f(h) - f(2 * h)) / (12 * h)


def _vee(A):
    return 0.5 * np.array([A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]])


def _tangent_map(theta):
    s = theta @ theta
    a, b, _, _ = rotations.tangent_coefficients(s)
    columns = [rotations.about(tuple(theta), 1.0 - s * b, a, b, tuple(e)) for e in np.eye(3)]
    return np.column_stack(columns)


@given(VECTOR, ANGLE)
def test_rotation_vector(v, angle):
    theta = angle * v
    expected = Rotation.from_rotvec(theta).as_matrix()
    np.testing.assert_allclose(rotations.vector_to_matrix(theta), expected, atol=1e-14)


@given(VECTOR, ANGLE, VECTOR)
def test_tangent_map_gives_the_angular_velocity(v, angle, rate):
    theta = angle * v
    A_d = _difference(lambda h: rotations.vector_to_matrix(theta + h * rate))
    w = _vee(A_d @ rotations.vector_to_matrix(theta).T)
    np.testing.assert_allclose(_tangent_map(theta) @ rate, w, atol=1e-10)


@given(VECTOR, ANGLE, VECTOR)
def test_tangent_rate(v, angle, rate):
    theta = angle * v
    expected = _difference(lambda h: _tangent_map(theta + h * rate) @ rate)
    _, b, da, db = rotations.tangent_coefficients(theta @ theta)
    found = tangent_rate(tuple(theta), tuple(rate), b, da, db)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@given(PARAMETERS.filter(lambda p: np.linalg.norm(p) > 0.1), VECTOR)
def test_euler_parameters(p, w_B):
    A = rotations.rotation_matrix(p)
    expected = Rotation.from_quat([p[1], p[2], p[3], p[0]]).as_matrix()
    np.testing.assert_allclose(A, expected, atol=1e-13)
    p_d = 0.5 * np.array(rotations.along_parameters(p, 0, *w_B))
    assert abs(p @ p_d) < 1e-14  # the norm is kept
    A_d = _difference(lambda h: rotations.rotation_matrix(p + h * p_d))
    np.testing.assert_allclose(A.T @ A_d, rotations.skew(w_B), atol=1e-9)


@given(VECTOR, ANGLE)
def test_matrix_to_parameters_inverts(v, angle):
    A = Rotation.from_rotvec(angle * v).as_matrix()
    p = rotations.matrix_to_parameters(A)
    np.testing.assert_allclose(rotations.rotation_matrix(p), A, atol=1e-13)


@given(VECTOR.filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_frame_from_axis(axis):
    A = rotations.frame_from_axis(axis)
    np.testing.assert_allclose(A.T @ A, np.eye(3), atol=1e-12)
    assert np.linalg.det(A) > 0
    np.testing.assert_allclose(A[:, 2], axis / np.linalg.norm(axis), atol=1e-15)
