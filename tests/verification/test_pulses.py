"""A pulse on a mechanism at rest is not stepped over: its impulse moves the body."""

import json

import pytest
from case_samples import HEAD, rigid

from plymotion.solver.__main__ import main

MASS, PEAK, WIDTH = 2.0, 50.0, 0.04
LINEAR = (
    "table = { times = [0.0, 0.5, 0.52, 0.54, 1.5], values = [0.0, 0.0, 50.0, 0.0, 0.0], "
    'interpolation = "linear" }'
)
BELL = 'expression = "50 * exp(-((t - 0.52) / 0.02)**2)"'
IMPULSES = {LINEAR: PEAK * WIDTH / 2.0, BELL: PEAK * 0.02 * 3.141592653589793**0.5}


@pytest.mark.parametrize("law", [LINEAR, BELL])
@pytest.mark.parametrize("integrator", ["radau", "rk8", "gear"])
def test_a_pulse_on_a_body_at_rest(tmp_path, law, integrator):
    case = tmp_path / "case.toml"
    text = (
        HEAD
        + rigid("block", MASS, 1.0, {"centre": (0, 0, 0)})
        + f"""
[forces.push]
kind = "force"
at = "block.centre"
direction = [1.0, 0.0, 0.0]
law = {{ {law} }}
[signals.speed]
kind = "velocity"
at = "block.centre"
component = "x"
[solver]
t_end = 1.5
output_step = 0.01
integrator = "{integrator}"
[runs.base]
"""
    )
    case.write_text(text, "utf-8")
    assert main([str(case), "--out", str(tmp_path / "build"), "--no-report", "--quiet"]) == 0
    summary = json.loads((tmp_path / "build/base/summary.json").read_text("utf-8"))
    assert summary["signals"]["speed"]["final"] == pytest.approx(IMPULSES[law] / MASS, rel=1e-3)
