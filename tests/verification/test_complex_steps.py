"""Linearised equations against complex steps, which are exact, in plain NumPy."""

import json
import os

import pytest
from harness.processes import this_python


@pytest.mark.parametrize(
    ("case", "run", "at"),
    [
        ("double-pendulum-limits", "isotropic-soft-free-stiffened", "start"),
        ("rotating-blade", "stiffened", "spin=60"),
        ("actuated-beam", "layup-2-root", "start"),  # bends by less than its own thickness
    ],
)
def test_differences_agree_with_complex_steps(repository, case, run, at):
    files = [f"cases/{case}/case.toml", f"tests/packages/{case}"]
    variables = {
        **os.environ,
        "PLYMOTION_COMPILED": "0",
        "PYTHONPATH": os.pathsep.join([str(repository), str(repository / "tests")]),
    }
    done = this_python(
        "tests/peers/complex_steps.py", *files, run, at, cwd=repository, env=variables, check=True
    )
    off = json.loads(done.stdout)
    assert off["accelerations"] < 1e-8
    assert off["velocities"] < 1e-10
