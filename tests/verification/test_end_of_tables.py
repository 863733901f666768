"""The end of a table: values up to the end of a run, rest after it, no drive that stops at once."""

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, computed_file, rigid, run_text

from plymotion.solver.__main__ import main

SPEED, MASS, ARM = 3.0, 2.0, 0.5
WHEEL = (
    rigid("wheel", MASS, 1.0, {"hub": (-ARM, 0, 0)})
    + """
[ground]
o = { position = [0.0, 0.0, 0.0] }
[joints.hinge]
kind = "revolute"
between = ["ground.o", "wheel.hub"]
axis = [0.0, 0.0, 1.0]
drive = { %s }
[signals.w]
kind = "angular_velocity"
at = "wheel.hub"
component = "z"
[signals.pull]
kind = "reaction"
joint = "hinge"
component = "magnitude"
quantity = "force"
"""
)


def table(end: float, interpolation: str = "spline") -> str:
    times = np.linspace(0.0, end, 5)
    return (
        f"table = {{ times = {times.tolist()}, values = {(SPEED * times).tolist()}, "
        f'interpolation = "{interpolation}" }}'
    )


@pytest.mark.parametrize("integrator", ["radau", "rk8", "rk5", "gear"])
@pytest.mark.parametrize(
    ("law", "t_end"),
    [
        (table(1.0), 1.0),
        (table(1.0, "pchip"), 1.0),
        (table(0.3), 0.1 * 3),  # t_end is one digit behind the table
        (table(0.1 * 3), 0.3),
        (f'expression = "{SPEED} * t if t < 1 else {SPEED}"', 1.0),
    ],
)
def test_a_drive_turns_up_to_the_last_instant(tmp_path, integrator, law, t_end):
    t, history, summary = _run(tmp_path, WHEEL % law, t_end, f'integrator = "{integrator}"')
    np.testing.assert_allclose(history["w"], SPEED, rtol=1e-5)
    np.testing.assert_allclose(history["pull"], MASS * ARM * SPEED**2, rtol=1e-4)
    assert summary["checks"]["energy_drift_relative"] < 1e-4
    assert t[-1] == t_end


def _run(folder, text, t_end, more):
    solver = f"\n[solver]\nt_end = {t_end!r}\noutput_step = {t_end / 2!r}\n{more}\n[runs.base]\n"
    result, summary = computed_file(folder / "case.toml", HEAD + text + solver)
    return result.t, {s.name: s.values for s in result.signals}, summary


def test_a_drive_that_ends_in_motion_is_refused(tmp_path, capsys):
    file = tmp_path / "case.toml"
    file.write_text(HEAD + WHEEL % table(0.5) + SOLVER.format(t_end=1.0, step=0.5, more=""))
    assert main(["check", str(file), "--out", str(tmp_path / "out")]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "joints.hinge.drive.table: ends at t = 0.5 s with a speed of 3" in told
    assert not (tmp_path / "out").exists()


def test_a_drive_that_comes_to_rest_rests(tmp_path):
    s = np.linspace(0.0, 1.0, 41)
    values = s**3 * (10.0 + s * (6.0 * s - 15.0))
    law = f"table = {{ times = {(0.5 * s).tolist()}, values = {values.tolist()} }}"
    _, history, summary = run_text(tmp_path, WHEEL % law, t_end=1.0, step=0.25)
    np.testing.assert_allclose(history["w"][3:], 0.0, atol=1e-6)
    assert summary["checks"]["energy_drift_relative"] < 1e-3
