"""Vibrations after a start from rest in a shape that moves."""

import numpy as np

from plymotion.solver.studies.fidelity.indicators.response import newmark, ringing


def test_one_mode_rings_with_the_rate_over_its_frequency():
    w, rate, zeta = 3000.0, 0.2, 0.05
    D = np.array([[2.0 * zeta * w]])
    found = ringing(np.eye(1), np.array([[w**2]]), D, np.array([rate]), 1e-3)
    t = np.linspace(0.0, 0.01, 50)
    q, v, a = found.history(t)
    fading = np.exp(-zeta * w * t)
    assert np.allclose(q[:, 0], -rate / w * np.sin(w * t) * fading, atol=1e-12 * rate / w)
    assert np.allclose(v[:, 0], -rate * np.cos(w * t) * fading, atol=1e-12 * rate)
    assert np.allclose(a[:, 0], rate * w * np.sin(w * t) * fading, atol=1e-12 * rate * w)
    assert np.allclose(found.rate, rate)


def test_resolved_vibrations_are_left_to_newmarks_method():
    found = ringing(np.eye(1), np.eye(1), np.zeros((1, 1)), np.ones(1), 1e-3)
    assert found.w.size == 0
    assert np.array_equal(found.rate, np.zeros(1))


def test_both_parts_together_are_the_response_with_small_steps():
    """Coupled masses, one slow and one fast vibration, a load that grows from the start."""
    M, K = np.array([[1.0, 0.3], [0.3, 0.5]]), np.diag([4e2, 4e6])
    D, steps = np.zeros((2, 2)), (200, 199001)
    out = []
    for n in steps:
        t = np.linspace(0.0, 0.2, n)
        p = np.outer(t, [3.0, 5e3])
        eta_rate = np.linalg.solve(K, p[1] - p[0]) / t[1]
        rings = ringing(M, K, D, eta_rate, t[1])
        smooth = newmark(t, p, M[None], np.array([0]), K, D, np.zeros(2), rings.rate)
        q = smooth[0] + rings.history(t)[0]
        out.append(q[:: (n - 1) // (steps[0] - 1)])
    assert out[0].shape[0] == steps[0]
    size = np.abs(out[1]).max(axis=0)
    assert (np.abs(out[0] - out[1][: steps[0]]).max(axis=0) < 0.03 * size).all()
