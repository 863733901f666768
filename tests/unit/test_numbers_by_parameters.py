"""Numbers of a case as expressions of its parameters, also where a sweep varies these."""

import json
from pathlib import Path

import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case

CASE = """
format = 1
title = "Ball on a spring"
gravity = [0.0, "-g", 0.0]

[parameters]
g = 9.81
m = 2.0
turn = 0.25

[bodies.ball]
kind = "rigid"
mass = "3 * m"
inertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, "1 + 0*m"]]
rotation_deg = [0.0, 0.0, "turn * 360"]
interfaces = { centre = { position = [0.0, 0.0, 0.0] } }

[ground.base]
position = [0.0, 1.0, 0.0]

[forces.spring]
kind = "spring"
between = ["ground.base", "ball.centre"]
stiffness = 100.0

[signals.height]
kind = "position"
at = "ball.centre"
component = "y"

[solver]
t_end = 0.1
output_step = 0.05

[runs.base]

[variants.heavy.parameters]
m = 4.0

[runs.heavy]
variants = ["heavy"]
"""
SWEEP = """
[sweeps.masses]
run = "base"
[sweeps.masses.vary]
"parameters.m" = [1.0, 5.0]
"""


def load(tmp_path: Path, text: str):
    file = tmp_path / "case.toml"
    file.write_text(text)
    return load_case(file)


def test_numbers_follow_the_parameters_of_a_run(tmp_path):
    runs = load(tmp_path, CASE).runs
    assert [runs[name].bodies["ball"].mass for name in ("base", "heavy")] == [6.0, 12.0]
    assert runs["base"].gravity == [0.0, -9.81, 0.0]
    assert runs["base"].bodies["ball"].rotation_deg == [0.0, 0.0, 90.0]


def test_a_sweep_of_a_parameter_changes_the_numbers_that_read_it(tmp_path):
    case = load(tmp_path, CASE + SWEEP)
    members = case.sweeps["masses"].own
    assert [change["bodies.ball.mass"] for change in members.changes] == [3.0, 15.0]
    assert [change["parameters.m"] for change in members.changes] == [1.0, 5.0]
    write_case(case, tmp_path / "out")
    table = json.loads((tmp_path / "out/sweeps/masses.json").read_text())
    assert table["members"][1]["changes"]["bodies.ball.mass"] == 15.0


def test_a_key_that_a_sweep_varies_itself_does_not_follow(tmp_path):
    more = SWEEP.replace("[1.0, 5.0]", '[1.0, 5.0]\n"bodies.ball.mass" = [7.0]')
    changes = load(tmp_path, CASE + more).sweeps["masses"].own.changes
    assert [change["bodies.ball.mass"] for change in changes] == [7.0, 7.0]


@pytest.mark.parametrize(
    "text", ["3 * mm", "t", "1 / (m - 2)", "3", "3 * m)", "__import__('os')", "ball.centre"]
)
def test_another_text_is_no_number(tmp_path, text):
    with pytest.raises(InputError) as error:
        load(tmp_path, CASE.replace("3 * m", text, 1))
    hint = "without quotes" if text == "3" else "or an expression of [parameters]"
    line = f'bodies.ball.mass = "{text}": value should be a valid number [kg], {hint}'
    assert line in str(error.value)


def test_a_member_without_a_number_is_named(tmp_path):
    text = CASE.replace('"3 * m"', '"1 / (m - 1)"') + SWEEP
    with pytest.raises(InputError, match=r'bodies.ball.mass = "1 / \(m - 1\)": expected a finite'):
        load(tmp_path, text)
