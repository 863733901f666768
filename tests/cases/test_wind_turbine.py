"""The turbine of cases/wind-turbine in its wind: rated operation, a clean report, ply margins."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case


@pytest.fixture(scope="module")
def turned(repository, tmp_path_factory):
    """Times, signals and summary of two turns in the wind at the start."""
    folder = case_runs(repository, "wind-turbine", tmp_path_factory.mktemp("build"))
    return run_case(folder / "gust.json", t_end=1.0)


def test_the_report_is_clean(turned):
    *_, summary = turned
    assert summary["completed"]
    assert summary["warnings"] == []


def test_it_runs_at_its_rated_power(turned):
    """Torque of the generator times speed, over a turn; the blades bend, and the wind has shear."""
    t, signals, _ = turned
    turn = t > t[-1] - 2.0 * np.pi / 10.0
    assert signals["speed"][turn].mean() == pytest.approx(10.0, rel=0.02)
    assert signals["power"][turn].mean() == pytest.approx(28e3, rel=0.05)


def test_the_lowest_margin_is_that_of_the_strength(turned):
    _, signals, summary = turned
    assert signals["margin"].min() == pytest.approx(summary["strength"]["blade-1"]["ratio"])
    assert 2.0 < signals["margin"].min() < 20.0


def test_the_root_of_a_blade_bends_by_thrust_and_weight(turned):
    """Edgewise, the weight moves the tip by turns; flapwise it stays on the suction side."""
    t, signals, _ = turned
    turn = t > t[-1] - 2.0 * np.pi / 10.0
    assert signals["flap"][turn].min() > 0.0
    assert np.ptp(signals["edge"][turn]) > 1e-3
