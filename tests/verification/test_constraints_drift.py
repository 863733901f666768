"""A01 pendulum: what every treatment makes of the constraint over 10 s. Eq. (13)."""

import numpy as np
import pytest
from samples.constraint_runs import run
from samples.mechanism_samples import pendulum

TIMES = [0.0, 1.0, 5.0, 9.99, 10.0]
INDEX_1 = ("index1", "baumgarte", "augmented-lagrangian", "projection")


@pytest.fixture(scope="module")
def exact(published):
    return np.array([(p["x"], p["y"]) for p in published("a01_pendulum")["positions"]])


@pytest.mark.parametrize("name", INDEX_1)
def test_position_after_ten_seconds(name, exact):
    done = run(pendulum(), name, TIMES, rtol=1e-10)
    assert np.abs(pendulum().place(done.solution.y)[1:, :2] - exact).max() < 1e-8


@pytest.mark.parametrize("name", ["ggl", "index3"])
def test_generalized_alpha_after_ten_seconds(name, exact):
    done = run(pendulum(), name, TIMES, rtol=1e-5)
    assert np.abs(pendulum().place(done.solution.y)[1:, :2] - exact).max() < 0.02


@pytest.mark.parametrize("integrator", ["rk8", "gear"])
def test_drift_grows_without_stabilisation(integrator):
    done = run(pendulum(), "index1", [0.0, 10.0], integrator, rtol=1e-7)
    after_2, after_10 = done.position[done.t < 2].max(), done.position[done.t > 8].max()
    assert after_10 > 1e-8
    assert after_10 > 4 * after_2


@pytest.mark.parametrize("integrator", ["rk8", "gear"])
@pytest.mark.parametrize("name", ["baumgarte", "augmented-lagrangian"])
def test_feedback_bounds_the_drift(name, integrator):
    free = run(pendulum(), "index1", [0.0, 10.0], integrator, rtol=1e-7)
    held = run(pendulum(), name, [0.0, 10.0], integrator, rtol=1e-7)
    after_2, after_10 = held.position[held.t < 2].max(), held.position[held.t > 8].max()
    assert after_10 < 2 * after_2
    assert after_10 < 0.1 * free.position.max()
    assert after_10 > 1e-14, "bounded, not gone"


@pytest.mark.parametrize("integrator", ["rk5", "rk8", "gear"])
def test_projection_removes_the_drift(integrator):
    """Positions and velocities to rounding, at steps and between them."""
    between = np.linspace(0.0, 10.0, 57)
    done = run(pendulum(), "projection", between, integrator, rtol=1e-5)
    assert done.position.max() <= 1.1e-12  # CLOSED and a rounding
    assert done.velocity.max() < 1e-12
    y = done.solution.y
    assert np.abs(np.linalg.norm(y[:, :3], axis=1) - 1.0).max() < 2e-12
    assert np.abs(np.sum(y[:, :3] * y[:, 7:10], axis=1)).max() < 1e-12
    assert np.abs(np.linalg.norm(y[:, 3:7], axis=1) - 1.0).max() < 1e-14


def test_ggl_keeps_positions_and_velocities_index_3_positions_only():
    ggl = run(pendulum(), "ggl", [0.0, 10.0], rtol=1e-5)
    assert ggl.position.max() < 1e-11
    assert ggl.velocity.max() < 1e-8
    index3 = run(pendulum(), "index3", [0.0, 10.0], rtol=1e-5)
    assert index3.position.max() < 1e-11
    assert index3.velocity.max() > 1e-5, "hidden constraints hold to the order of the method"


def test_projection_takes_energy_from_velocities_only_by_rounding():
    """Gauss: the nearest velocity on the constraints has less kinetic energy."""
    loose = run(pendulum(), "projection", [0.0, 10.0], "rk8", rtol=1e-4)
    tight = run(pendulum(), "projection", [0.0, 10.0], "rk8", rtol=1e-9)
    assert np.ptp(loose.energy) < 5e-2
    assert np.ptp(tight.energy) < 1e-7
