"""Unstable feedback: told, and ended where it only turns faster and faster."""

import pytest
from samples.coordinate_samples import DEFAULT, carriage, force, run, wheel

UNSTABLE = {"proportional": 400.0, "derivative": 2.0, "filter_time": 0.001, "sample_time": 0.02}


def codes(summary):
    return {w["code"]: w["message"] for w in summary["warnings"]}


@pytest.mark.provokes("motion-grows")
def test_a_slide_that_is_driven_away_is_told(tmp_path):
    """m x'' = u, sampled with 4000 N/m at 20 ms: eigenvalues of the sampled loop are outside the
    unit circle."""
    gains = UNSTABLE | {"proportional": 4000.0, "derivative": 20.0}
    text = carriage(force("motor", "controller", joint="rail", setpoint="1.0", **gains))
    _, _, summary = run(tmp_path, text, 1.0, 0.01, DEFAULT)
    assert summary["completed"]
    assert "unstable: motor" in codes(summary)["motion-grows"]


def test_a_wheel_that_turns_beyond_all_measure_ends_the_run(tmp_path):
    """Each turn takes steps: the run would take hours, and none of them are vibrations."""
    text = wheel(
        force("motor", "controller", joint="axle", setpoint="1.0", **UNSTABLE), inertia=0.1
    )
    _, _, summary = run(tmp_path, text, 3.0, 0.01, DEFAULT)
    assert summary["status"] == "failed"
    assert summary["cost"]["steps"] < 20_000
    found = codes(summary)
    assert "no material holds" in found["run-failed"]
    assert "unstable" in found["run-failed"]
    assert "vibration-damped" not in found


@pytest.mark.parametrize("law", ["smooth_step = { value = 5e3, duration = 1.0 }", "constant = 5e3"])
def test_loads_that_accelerate_are_no_growth(tmp_path, law):
    """2 t^6 of kinetic energy, from rest far beyond the speed of size over duration."""
    text = carriage(
        '[forces.push]\nkind = "force"\nat = "car.a"\ndirection = [1.0, 0.0, 0.0]\n'
        f"law = {{ {law} }}\n"
    )
    _, _, summary = run(tmp_path, text, 1.0, 0.01, DEFAULT)
    assert summary["warnings"] == []


def test_a_fast_wheel_is_no_stall(tmp_path):
    """5000 rad/s with results every 10 ms: its steps are those of the rotation."""
    _, history, summary = run(tmp_path, wheel(spin=5000.0), 0.5, 0.01, DEFAULT)
    assert summary["cost"]["steps"] > 2000
    assert summary["warnings"] == []
    assert abs(history["angle"][-1] - 2500.0) < 1e-2
