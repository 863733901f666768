"""Angles over many turns between two outputs: the steps count them, not the outputs."""

import numpy as np
import pytest
from samples.case_samples import HEAD, computed_file, rigid

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
@pytest.mark.parametrize(
    ("step", "damping"),
    [(0.05, DAMPING), (1.7, DAMPING), (2.3, DAMPING), (T_END, DAMPING), (1.7, 0)],
)
def test_angles_do_not_depend_on_the_outputs(tmp_path, step, damping, integrator):
    """Without damping, the error of a step allows `generalized-alpha` to take turns in one."""
    more = 'constraints = "ggl"' if integrator == "generalized-alpha" else ""
    solver = (
        f"[solver]\nt_end = {T_END}\noutput_step = {step}\n"
        f'integrator = "{integrator}"\n{more}\n[runs.base]\n'
    )
    wheel = WHEEL.replace(f"-{DAMPING} * v", f"-{damping} * v")
    result, _ = computed_file(tmp_path / "case.toml", HEAD + wheel + solver)
    rate = max(damping, 1e-12) / INERTIA
    exact = -SPEED / rate * np.expm1(-rate * result.t)
    for signal in result.signals:
        np.testing.assert_allclose(signal.values, exact, atol=0.01)
