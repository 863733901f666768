"""Angles over many turns between two outputs: the steps count them, not the outputs."""

import numpy as np
import pytest
from samples.case_samples import HEAD, rigid

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run

SPEED, DAMPING, INERTIA, T_END = 20.0, 0.3, 0.5, 10.0
WHEEL = (
    rigid("wheel", 2.0, INERTIA, {"hub": (0, 0, 0)}, angular_velocity=[0, 0, SPEED])
    + f"""
[ground]
o = {{ position = [0.0, 0.0, 0.0] }}
[joints.pin]
kind = "revolute"
between = ["ground.o", "wheel.hub"]
axis = [0.0, 0.0, 1.0]
[forces.brake]
kind = "coordinate_force"
joint = "pin"
expression = "-{DAMPING} * v"
[signals.angle]
kind = "joint"
joint = "pin"
coordinate = "angle"
[signals.turned]
kind = "orientation"
at = "wheel.hub"
component = "z"
"""
)


@pytest.mark.parametrize("integrator", ["radau", "rk8", "gear", "generalized-alpha"])
@pytest.mark.parametrize("step", [0.05, 1.7, 2.3, T_END])
def test_angles_do_not_depend_on_the_outputs(tmp_path, step, integrator):
    more = 'constraints = "ggl"' if integrator == "generalized-alpha" else ""
    solver = (
        f"[solver]\nt_end = {T_END}\noutput_step = {step}\n"
        f'integrator = "{integrator}"\n{more}\n[runs.base]\n'
    )
    (tmp_path / "case.toml").write_text(HEAD + WHEEL + solver)
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build", None)
    result, _ = execute(read_run(tmp_path / "build/runs/base.json"), progress=False)
    rate = DAMPING / INERTIA
    exact = SPEED / rate * (1.0 - np.exp(-rate * result.t))
    for signal in result.signals:
        np.testing.assert_allclose(signal.values, exact, atol=0.01)
