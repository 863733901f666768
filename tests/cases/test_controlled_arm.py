"""The controlled arm: gears, sampled controllers, friction and a stop on laminated links."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case


@pytest.fixture(scope="module")
def runs(repository, tmp_path_factory):
    return case_runs(repository, "controlled-arm", tmp_path_factory.mktemp("build"))


@pytest.fixture(scope="module")
def both(runs):
    return {name: run_case(runs / f"{name}.json") for name in ("free", "stopped")}


def test_no_warnings_and_the_balance_of_energy(both):
    for _, _, summary in both.values():
        assert summary["completed"]
        assert summary["warnings"] == []
        assert summary["checks"]["energy_drift_relative"] < 1e-5
        assert summary["checks"]["momentum_balance"] < 1e-8


def test_it_reaches_the_end_of_its_motion(both):
    t, s, _ = both["free"]
    late = t > 1.1
    np.testing.assert_allclose(s["shoulder"][late], 1.2, atol=0.03)
    np.testing.assert_allclose(s["elbow"][late], -1.6, atol=0.03)
    # forearm and payload, accelerated less than by 2 g: d < 2 (m + rho A L / 3) g L^3 / 3 E I
    assert 1e-5 < np.abs(s["deflection"]).max() < 1e-3


def test_the_stop_holds_the_shoulder(both):
    _, s, _ = both["stopped"]
    assert 1.0 < s["shoulder"].max() < 1.04
    free = both["free"][1]
    before = free["shoulder"] < 0.95
    first = int(np.argmin(before))
    np.testing.assert_allclose(s["shoulder"][:first], free["shoulder"][:first], atol=1e-9)
    assert np.abs(s["deflection"]).max() > 2.0 * np.abs(free["deflection"]).max()


def test_tight_tolerances_do_not_change_it(runs, both):
    """Default settings against a run a thousand times as accurate; also the explicit method."""
    t, found, _ = both["stopped"]
    _, fine, _ = run_case(runs / "stopped.json", t_end=0.3, rtol=1e-7)
    n = int(np.searchsorted(t, 0.3)) + 1
    np.testing.assert_allclose(found["shoulder"][:n], fine["shoulder"], atol=2e-4)
    np.testing.assert_allclose(found["tip_y"][:n], fine["tip_y"], atol=2e-4)
