"""Steps along the group: rates, exponential, length of Euler parameters."""

import numpy as np
from samples.flexible_samples import body_of, random_points, random_state

from plymotion.solver.dynamics.model.coordinates import moved, position_rates
from plymotion.solver.math.rotations import rotation_matrix, vector_to_matrix
from plymotion.solver.mechanism.assembly import assemble_model


def _two_bodies():
    rng = np.random.default_rng(9)
    model = assemble_model([body_of(random_points(rng, m)) for m in (2, 0)], [], [])
    y = random_state(rng, model)
    for a in model.pos_start:
        y[a + 3 : a + 7] /= np.linalg.norm(y[a + 3 : a + 7])
    return model, y[: model.n_pos], rng.normal(size=model.n_vel)


def test_a_small_step_moves_by_the_rates():
    model, q, v = _two_bodies()
    h = 1e-6
    change = (moved(model, q, h * v) - moved(model, q, -h * v)) / (2 * h)
    np.testing.assert_allclose(change, position_rates(model, q, v), atol=1e-9)


def test_a_rotation_is_the_exponential_in_body_axes():
    model, q, v = _two_bodies()
    far = moved(model, q, v)
    for a, j, m in zip(model.pos_start, model.vel_start, model.n_mode, strict=True):
        expected = rotation_matrix(q[a + 3 : a + 7]) @ vector_to_matrix(v[j + 3 : j + 6].copy())
        np.testing.assert_allclose(rotation_matrix(far[a + 3 : a + 7]), expected, atol=1e-14)
        np.testing.assert_allclose(far[a : a + 3], q[a : a + 3] + v[j : j + 3])
        np.testing.assert_allclose(
            far[a + 7 : a + 7 + m], q[a + 7 : a + 7 + m] + v[j + 6 : j + 6 + m]
        )


def test_euler_parameters_come_out_with_length_one():
    model, q, _ = _two_bodies()
    q = q.copy()
    q[3:7] *= 1.7
    still = moved(model, q, np.zeros(model.n_vel))
    assert abs(np.linalg.norm(still[3:7]) - 1.0) < 1e-15
    np.testing.assert_allclose(still[3:7], q[3:7] / 1.7, rtol=1e-15)
