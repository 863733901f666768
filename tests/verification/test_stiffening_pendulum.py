"""The soft double pendulum in clamped frames, and the geometric stiffness of its bodies."""

import numpy as np
from samples.flexible_samples import simulate
from samples.stiffening_samples import CHORD, CLAMPED, soft_modes, soft_pendulum

from plymotion.solver.checks.stability import SpinMonitor, geometric_stiffness
from plymotion.solver.dynamics.evaluation.accelerations import accelerations, assemble


def test_clamped_frames_complete_with_the_error_of_large_rotations(published):
    """Rotations of 0.25 rad relative to the frame: the terms that second order neglects are
    documented."""
    expected = published("double_pendulum")["isotropic-soft-free"]
    pendulum = soft_pendulum(CLAMPED, soft_modes(2, static=False), elements=16)
    states = simulate(pendulum.model, pendulum.y0, np.array([0.0, 1.0]), rtol=1e-6)
    tip = pendulum.place(pendulum.tip, states[-1])[:2]
    error = np.linalg.norm(tip - expected["tip"])
    assert 5e-3 < error < expected["stiffened_clamped_tip_tolerance"]


def test_geometric_stiffness_is_the_slope_of_the_forces_at_held_accelerations():
    """K + Kg less what spinning takes, against differences of the elastic rows of the equations."""
    pendulum = soft_pendulum(CHORD, soft_modes(2), elements=8)
    model, y = pendulum.model, pendulum.y0.copy()
    v_d, multipliers = accelerations(model, assemble(model, 0.0, y), y)
    i, m = 0, int(model.n_mode[0])
    a, j = int(model.pos_start[i]) + 7, int(model.vel_start[i]) + 6

    def unbalanced(state):
        equations = assemble(model, 0.0, state)
        left = equations.M @ v_d + equations.Phi_q.T @ multipliers - equations.f
        return left[j : j + m]

    h = 1e-6
    slope = np.zeros((m, m))
    for k in range(m):
        for sign in (1.0, -1.0):
            state = y.copy()
            state[a + k] += sign * h
            slope[:, k] += sign * unbalanced(state) / (2.0 * h)
    slope = 0.5 * (slope + slope.T)
    monitor = SpinMonitor(model, ["arm", "hand"])
    K, lost = monitor.matrices(i, y)
    of_both = monitor.matrices(i, np.stack([y, 0.5 * y]))[1]  # by the square of the spin
    np.testing.assert_allclose(of_both, [lost, 0.25 * lost], atol=1e-12 * np.abs(lost).max())
    Kg = geometric_stiffness(model, model, i, np.zeros(1), y[None])[0]
    scale = 1.0 / np.sqrt(np.outer(np.diag(K), np.diag(K)))
    geometric = scale * Kg
    gap = scale * (slope - (K - lost + Kg))
    assert np.abs(geometric).max() > 0.01
    assert np.abs(gap).max() < 0.02 * np.abs(geometric).max()
