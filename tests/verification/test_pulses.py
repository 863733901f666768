"""A pulse on a mechanism at rest is not stepped over: its impulse moves the body."""

import json

import numpy as np
import pytest
from samples.case_samples import HEAD, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.preparation import prepare

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
    final, _ = speed(tmp_path, law, 1.5, f'integrator = "{integrator}"', 0.01)
    assert final == pytest.approx(IMPULSES[law] / MASS, rel=1e-3)


def speed(folder, law, t_end, solver, output_step):
    """The speed of a block at the end of a run under a load, and the checks."""
    case = folder / "case.toml"
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
t_end = {t_end}
output_step = {output_step}
{solver}
[runs.base]
"""
    )
    case.write_text(text, "utf-8")
    assert main([str(case), "--out", str(folder / "build"), "--no-report", "--quiet"]) == 0
    summary = json.loads((folder / "build/base/summary.json").read_text("utf-8"))
    return summary["signals"]["speed"]["final"], summary["checks"]


def pulse(at: float, width: float, size: float, t_end: float) -> str:
    """A triangle in a table."""
    times = [0.0, at, at + 0.5 * width, at + width, t_end]
    return f"table = {{ times = {times}, values = [0.0, 0.0, {2.0 * size}, 0.0, 0.0] }}"


# Short pulses of 1.4 N s, and the end of the run; rk8 took one step over each of them.
SHORT = {
    "triangle": (pulse(5.0, 1e-3, 1400.0, 10.0), 10.0),
    "square": ('expression = "1400 if 5 < t < 5.001 else 0"', 10.0),
    "shifted": ('expression = "1400 if sin(t - 5) > 0 and sin(5.001 - t) > 0 else 0"', 7.0),
    "last instant": ('expression = "1400 * step(t - 9.999)"', 10.0),
    "bell": (f'expression = "14000 * exp(-((t - 5) / 1e-4)**2) / {3.141592653589793**0.5}"', 10.0),
    "difference": ('expression = "700*(tanh((t - 5) / 1e-5) - tanh((t - 5.001) / 1e-5))"', 10.0),
    "ten": ('expression = "140 if t + 0.5 - floor(t + 0.5) < 0.001 else 0"', 10.0),
    "burst": ('expression = "1400*pi*sin(1000*pi*(t - 5)) if 5 < t < 5.001 else 0"', 10.0),
    "curve": ('expression = "(exp(min(0, 5 - t)*1e3) if t > 5 else 0)*1400"', 10.0),
}
IMPULSE = {"burst": 2.8}


@pytest.mark.parametrize("name", SHORT)
@pytest.mark.parametrize("integrator", ["radau", "rk8", "rk5", "gear", "generalized-alpha"])
def test_short_pulses(tmp_path, name, integrator):
    law, t_end = SHORT[name]
    solver = f'integrator = "{integrator}"'
    if integrator == "generalized-alpha":
        solver += '\nconstraints = "ggl"'
    final, checks = speed(tmp_path, law, t_end, solver, 3.0)
    assert final == pytest.approx(IMPULSE.get(name, 1.4) / MASS, rel=1e-3)
    assert checks["energy_drift_relative"] < 1e-3


def test_a_pulse_in_the_last_microsecond_by_gear(tmp_path):
    """Points of long steps before it made its error 1e-5 of what it is: 0.722."""
    law = "times = [0.0, 9.999999, 10.0], values = [0.07, 0.07, 1.4e6]"
    law = f'table = {{ {law}, interpolation = "linear" }}'
    final, _ = speed(tmp_path, law, 10.0, 'integrator = "gear"', 3.0)
    assert final == pytest.approx(1.4 / MASS, rel=1e-4)


@pytest.mark.parametrize("integrator", ["radau", "rk8"])
def test_a_pulse_at_the_peak_of_a_state(tmp_path, integrator):
    """sin(t) is above 1 - 1e-6 within a fifth of a step; states were taken as linear in each."""
    law = "expression = \"1000 * max(0, state('s') - 0.999999) / 1e-6\""
    solver = f'integrator = "{integrator}"\n[states.s]\nrate = "cos(t)"'
    final, _ = speed(tmp_path, law, 2.0, solver, 0.5)
    assert final == pytest.approx(4000.0 / 3.0 * 2e-6**0.5 / MASS, rel=1e-4)


@pytest.mark.parametrize("width", [1e-4, 1e-2])
def test_the_first_step_of_a_pulse_by_generalized_alpha(tmp_path, width):
    """Behind a kink there is no step before, with which its rates could be compared."""
    law = pulse(5.0, width, 1.4 / width, 10.0).replace("}", ', interpolation = "pchip" }')
    solver = 'integrator = "generalized-alpha"\nconstraints = "ggl"'
    final, checks = speed(tmp_path, law, 10.0, solver, 3.0)
    assert final == pytest.approx(1.4 / MASS, rel=1e-5)
    assert checks["energy_drift_relative"] < 1e-4


def test_a_pulse_in_a_long_run(tmp_path):
    final, _ = speed(tmp_path, pulse(30.0, 0.01, 1400.0, 60.0), 60.0, 'integrator = "radau"', 7.0)
    assert final == pytest.approx(7.0, rel=1e-5)


def test_a_pulse_in_a_long_record(tmp_path):
    """Noise at 100,000 points, and 1 ms that is a thousand times as large."""
    t = np.linspace(0.0, 10.0, 100_001)
    values = np.sin(1e5 * t**2)
    inside = (t > 5.0) & (t < 5.001)
    values[inside] += 1400.0
    np.savetxt(tmp_path / "load.csv", np.column_stack([t, values]), "%.17g", ",")
    law = 'table = { file = "load.csv" }'
    exact = float(((values[1:] + values[:-1]) * 0.5 * np.diff(t)).sum()) / MASS
    final, _ = speed(tmp_path, law, 10.0, 'integrator = "radau"', 1.0)
    assert final == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("integrator", ["radau", "rk8", "rk5", "gear", "generalized-alpha"])
def test_fixed_steps_end_at_breaks(tmp_path, integrator):
    """Ten steps for the run, with the speed of the exact impulse."""
    treatment = 'constraints = "ggl"' if integrator == "generalized-alpha" else ""
    case = tmp_path / "case.toml"
    speed(
        tmp_path,
        pulse(5.0, 1e-3, 1400.0, 10.0),
        10.0,
        f'integrator = "{integrator}"\n{treatment}',
        1.0,
    )
    spec = read_run(case.parent / "build/runs/base.json")
    ready = prepare(spec.mechanism, spec.packages)
    made = make_integrator(
        ready.model, ready.y0, spec.mechanism.solver, ready.treatment, fixed_step=1.0
    )
    found = integrate(made, np.array([0.0, 10.0]))
    assert found.y[-1, ready.model.n_pos] == pytest.approx(0.7, rel=0.1)


@pytest.mark.provokes("breaks-not-searched")
def test_breaks_that_are_too_many_to_be_searched_are_told(tmp_path):
    """100,000 kinks; each remedy of the finding clears it."""
    law = 'expression = "1e-9 * abs(sin(1e6 * t))"'
    runs = ((0.3, "", True), (0.3, "max_step = 0.01", False), (0.03, "", False))
    for t_end, solver, told in runs:
        speed(tmp_path, law, t_end, f'integrator = "rk8"\n{solver}', 0.01)
        summary = json.loads((tmp_path / "build/base/summary.json").read_text("utf-8"))
        codes = [finding["code"] for finding in summary["warnings"]]
        assert ("breaks-not-searched" in codes) == told
    table = "table = { times = [0.0, 0.1, 0.3], values = [0.0, 1e-9, 0.0] }"
    speed(tmp_path, table, 0.3, 'integrator = "rk8"', 0.01)
    assert "breaks-not-searched" not in (tmp_path / "build/base/summary.json").read_text("utf-8")
