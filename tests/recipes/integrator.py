"""A pendulum by the integrator of the recipe; argument: a folder to write to."""

import sys
from pathlib import Path

import numpy as np
from samples.case_samples import HEAD, rigid

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run

folder = Path(sys.argv[1])
PENDULUM = (
    "gravity = [0.0, -9.81, 0.0]\n[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("ball", 2.0, 0.1, {"end": (-1, 0, 0)}, position=(1, 0, 0))
    + '[joints.hinge]\nkind = "revolute"\nbetween = ["ground.O", "ball.end"]\n'
    + '[signals.x]\nkind = "position"\nat = "ball.end"\ncomponent = "x"\n'
    + '[signals.angle]\nkind = "joint"\njoint = "hinge"\ncoordinate = "angle"\n'
)


def checked(**keys):
    """The case with these keys of `[solver]`."""
    solver = {"t_end": 0.2, "output_step": 0.1, "integrator": '"heun"', **keys}
    lines = [f"{key} = {value}" for key, value in solver.items()]
    file = folder / "case.toml"
    file.write_text("\n".join([HEAD + PENDULUM, "[solver]", *lines, "[runs.base]\n"]))
    return load_case(file)


def signals(**keys):
    """Signals by name, and what the run cost."""
    write_case(checked(**keys), folder / "build")
    result, summary = execute(read_run(folder / "build/runs/base.json"), progress=False)
    assert summary["status"] == "finished", summary
    return {s.name: s.values for s in result.signals}, summary["cost"]


def message(**keys):
    """What is said of a case with these keys of `[solver]`."""
    try:
        checked(**keys)
    except InputError as error:
        return str(error)
    return ""


exact, _ = signals(integrator='"rk8"', rtol=1e-10, atol_position=1e-12, atol_velocity=1e-12)
tried = {}
for corrections in (1, 2):
    found, cost = signals(rtol=1e-5, corrections=corrections)
    assert cost["integrator"] == "heun"
    assert abs(found["angle"][-1] - exact["angle"][-1]) < 1e-3
    assert np.abs(found["x"]).max() < 1e-9  # every step is projected
    tried[corrections] = cost["evaluations"] / cost["steps"]
assert tried[2] > tried[1] + 0.5

assert not message(corrections=3)
for words, keys in {
    "solver.corrections = 10: value should be less than or equal to 9": {"corrections": 10},
    "solver.correction: unknown key; did you mean 'corrections'": {"correction": 1},
    "did you mean 'heun'": {"integrator": '"huen"'},
    'integrator = "heun": expected integrator = "generalized-alpha"': {"constraints": '"ggl"'},
}.items():
    assert words in message(**keys), message(**keys)
