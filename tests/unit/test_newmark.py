"""Newmark's method: closed form of one oscillator, steps of coupled modes written out."""

import numpy as np
import pytest

from plymotion.solver.studies.fidelity.indicators.response import BETA, GAMMA, newmark


def one(value):
    return np.array([[value]])


@pytest.mark.parametrize("deformed", [False, True])
def test_an_oscillator_under_a_constant_load(deformed):
    """From zero it vibrates about K^-1 p, with the errors of the method; in balance it stays."""
    t, w, load = np.linspace(0.0, 1.0, 2001), 20.0, 3.0
    start = np.array([[load / w**2], [0.0]]) if deformed else None
    q, v, _ = newmark(
        t, np.full((len(t), 1), load), one(1.0)[None], np.array([0]), one(w**2), one(0.0), start
    )
    exact = np.full(len(t), load / w**2) if deformed else load / w**2 * (1.0 - np.cos(w * t))
    # gamma = 0.55: amplitudes decrease by (gamma - 1/2) w^2 h t / 2 at most
    lost = 0.5 * (GAMMA - 0.5) * w**2 * t[1]
    assert np.abs(q[:, 0] - exact).max() <= (0.0 if deformed else 1.2 * lost) * load / w**2 + 1e-15
    assert np.abs(v).max() <= (1e-13 if deformed else load / w)


def test_coupled_modes_with_other_masses_and_steps():
    """Each row fulfils the equation with the mass of its segment, and the rules of the method."""
    rng = np.random.default_rng(5)
    t = np.concatenate([np.linspace(0.0, 0.5, 6), np.linspace(0.52, 0.6, 5)])
    m, at = 3, np.array([0, 4, 7])
    A = rng.normal(size=(len(at), m, m))
    masses = A @ A.transpose(0, 2, 1) + 3.0 * np.eye(m)
    K, D = np.diag([5.0, 40.0, 300.0]), np.diag([0.1, 0.2, 0.3])
    p = rng.normal(size=(len(t), m))
    q, v, a = newmark(t, p, masses, at, K, D, None)
    assert np.allclose(masses[0] @ a[0], p[0], rtol=1e-12)
    for k in range(1, len(t)):
        h, M = t[k] - t[k - 1], masses[np.flatnonzero(at <= k)[-1]]
        size = np.abs(M).max() * np.abs(a[k]).max()
        assert np.abs(M @ a[k] + D @ v[k] + K @ q[k] - p[k]).max() < 1e-10 * size
        mean = (0.5 - BETA) * a[k - 1] + BETA * a[k]
        assert np.allclose(q[k], q[k - 1] + h * v[k - 1] + h**2 * mean, rtol=1e-12, atol=1e-14)
        rate = (1.0 - GAMMA) * a[k - 1] + GAMMA * a[k]
        assert np.allclose(v[k], v[k - 1] + h * rate, rtol=1e-12, atol=1e-14)


def test_no_modes():
    empty = np.zeros((0, 0))
    q, _, _ = newmark(
        np.linspace(0.0, 1.0, 4),
        np.zeros((4, 0)),
        np.zeros((1, 0, 0)),
        np.array([0]),
        empty,
        empty,
        None,
    )
    assert q.shape == (4, 0)
