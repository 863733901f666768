"""The slider crank of the repository: closed forms of the rigid one, the flexible one near it."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case


@pytest.fixture(scope="module")
def found(repository, tmp_path_factory):
    runs = case_runs(repository, "slider-crank", tmp_path_factory.mktemp("build"))
    names = ("rigid", "steel", "carbon-0")
    return {name: run_case(runs / f"{name}.json", t_end=0.06) for name in names}


def test_rigid_slider_and_torque(found):
    t, s, summary = found["rigid"]
    angle = s["crank_angle"]
    height = 0.15 * np.sin(angle)
    np.testing.assert_allclose(
        s["slider_x"], 0.15 * np.cos(angle) + np.sqrt(0.09 - height**2), atol=1e-8
    )
    assert angle[-1] == pytest.approx(150.0 * (0.06 - 0.01), abs=1e-5)
    # What the drive does in work is what the energy gains.
    work = np.trapezoid(s["torque"] * np.gradient(angle, t), t)
    assert work == pytest.approx(summary["checks"]["drive_work"], rel=2e-3)


def test_flexible_rods_follow_the_rigid_one(found):
    _, rigid, _ = found["rigid"]
    for name, largest in (("steel", 2.5e-3), ("carbon-0", 2.5e-3)):
        _, s, summary = found[name]
        assert summary["completed"]
        assert summary["checks"]["energy_drift_relative"] < 1e-5
        assert 1e-4 < np.abs(s["rod_mid"]).max() < largest
        # A bent rod is no shorter in a linear body: the slider does not see the bending.
        np.testing.assert_allclose(s["slider_x"], rigid["slider_x"], atol=1e-6)


def test_rod_swings_with_its_frequency(found):
    """After the run-up the pinned rod's first mode, 203 Hz, rides on the forced bending."""
    t, s, _ = found["steel"]
    late = t > 0.02
    swing = s["rod_mid"][late]
    crossings = np.flatnonzero(np.diff(np.sign(swing - swing.mean())))
    assert len(crossings) >= 4
