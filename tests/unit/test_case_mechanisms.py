"""Joints, drives, forces and signals of a case file: bad ones get one line, good ones a model."""

import re

import numpy as np
import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.dynamics.evaluation.laws import law_at
from plymotion.solver.inputs.case.load import load_case, source_files
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.mechanism.build import build
from plymotion.solver.run.execution import read_run

SOURCE = """
format = 1
title = "Rigid bodies with one joint of each kind"

[bodies.one]
kind = "rigid"
mass = 1.0
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
interfaces = { a = { position = [0, 0, 0] }, b = { position = [1, 0, 0] } }

[bodies.two]
kind = "rigid"
mass = 1.0
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
position = [1.0, 0.0, 0.0]
interfaces = { a = { position = [0, 0, 0] }, b = { position = [1, 0, 0] } }

[ground.O]
position = [0.0, 0.0, 0.0]

[ground.far]
position = [3.0, 0.0, 0.5]

[joints.hinge]
kind = "revolute"
between = ["ground.O", "one.a"]
axis = [0.0, 0.0, 1.0]
drive = { ramp = { speed = 2.0, duration = 0.5 }, angle = 0.3 }

[joints.cross]
kind = "universal"
between = ["one.b", "two.a"]
axis = [0.0, 1.0, 0.0]
axis_2 = [0.0, 0.0, 2.0]

[joints.sleeve]
kind = "cylindrical"
between = ["ground.far", "two.b"]
axis = [0.0, 0.0, 1.0]
translation_drive = { smooth_step = { value = 0.2, duration = 1.0 } }

[forces.coil]
kind = "spring"
between = ["ground.far", "two.b"]
stiffness = 100.0

[forces.mount]
kind = "bushing"
between = ["ground.O", "two.a"]
stiffness = [1.0, 2.0, 3.0]

[forces.push]
kind = "force"
at = "two.b"
direction = [0.0, 2.0, 0.0]
law = { table = { times = [0.0, 0.5, 1.0], values = [0.0, 3.0, 1.0] } }

[signals.turn]
kind = "joint"
joint = "hinge"
coordinate = "angle"

[solver]
t_end = 1.0
output_step = 0.1

[runs.base]
"""

BAD = {
    "zero axis": (
        "axis = [0.0, 0.0, 1.0]\ndrive",
        "axis = [0.0, 0.0, 0.0]\ndrive",
        r"joints\.hinge\.axis = \[0\.0, 0\.0, 0\.0\]: expected a vector of non-zero length",
    ),
    "zero direction": (
        "direction = [0.0, 2.0, 0.0]",
        "direction = [0.0, 0.0, 0.0]",
        r"forces\.push\.direction = .*expected a vector of non-zero length",
    ),
    "arms of a cross": (
        "axis_2 = [0.0, 0.0, 2.0]",
        "axis_2 = [0.0, 1.0, 2.0]",
        r"joints\.cross\.axis_2 = \[0\.0, 1\.0, 2\.0\]: expected a vector at a right angle",
    ),
    "inertia of a rod": (  # singular, whichever sign the rounding has
        "inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
        "inertia = [[0.64, -0.288, -0.384], [-0.288, 0.7696, -0.3072], [-0.384, -0.3072, 0.5904]]",
        r"bodies\.one\.inertia = .*expected a symmetric, positive definite 3x3 matrix",
    ),
    "small and unsymmetric inertia": (  # of a part of a gram and a millimetre
        "inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
        "inertia = [[1e-9, 2e-10, 0], [0, 1e-9, 0], [0, 0, 1e-9]]",
        r"bodies\.one\.inertia = .*expected a symmetric, positive definite 3x3 matrix",
    ),
    "no law": ("ramp = { speed = 2.0, duration = 0.5 }, ", "", r"expected one law of speed, ramp"),
    "two laws": ("angle = 0.3", "speed = 1.0", r"expected one law of .*; found speed and ramp"),
    "offset without use": (
        "ramp = { speed = 2.0, duration = 0.5 }",
        "polynomial = [0, 1]",
        r"joints\.hinge\.drive = .*expected an offset with speed or ramp only",
    ),
    "unknown law": ("ramp = { speed", "rampp = { speed", r"drive\.rampp: unknown key; .*'ramp'"),
    "no such kind": ('"cylindrical"', '"cilindrical"', r'"cilindrical".*did you mean \'cylindric'),
    "drive of another joint": (
        "translation_drive",
        "drive",
        r"joints\.sleeve\.drive: unknown key; did you mean",
    ),
    "NaN in a table": (
        "values = [0.0, 3.0, 1.0]",
        "values = [0.0, nan, 1.0]",
        r"forces\.push\.law\.table\.values\.1 = nan: value should be a finite number",
    ),
    "times that turn back": (
        "times = [0.0, 0.5, 1.0]",
        "times = [0.0, 0.5, 0.4]",
        r"forces\.push\.law\.table = .*times\[2\] = 0\.4: expected more than 0\.5",
    ),
    "times that begin late": (
        "times = [0.0, 0.5, 1.0]",
        "times = [0.1, 0.5, 1.0]",
        r"times\[0\] = 0\.1: expected 0 or before",
    ),
    "values without times": (
        "times = [0.0, 0.5, 1.0], ",
        "",
        r"law\.table = .*expected `times` and `values`, or `file`",
    ),
    "no such file": (
        "times = [0.0, 0.5, 1.0], values = [0.0, 3.0, 1.0]",
        'file = "push.csv"',
        r"forces\.push\.law\.table = .*push\.csv: cannot be read",
    ),
    "drive that ends early": (
        "smooth_step = { value = 0.2, duration = 1.0 }",
        "table = { times = [0.0, 0.5], values = [0.0, 0.1] }",
        r"joints\.sleeve\.translation_drive\.table: ends at t = 0\.5 s with a speed of 0\.2, "
        r".*; expected times up to solver\.t_end = 1 s",
    ),
    "two drives on one coordinate": (
        "[forces.coil]",
        '[joints.again]\nkind = "prismatic"\nbetween = ["ground.O", "two.a"]\n'
        "axis = [0.0, 0.0, -1.0]\ndrive = { speed = 1.0 }\n\n[forces.coil]",
        r"joints\.again\.drive: expected one drive on a coordinate; "
        r"joints\.sleeve\.translation_drive has it",
    ),
    "same place twice": (
        '["one.b", "two.a"]',
        '["one.b", "one.b"]',
        r"joints\.cross\.between = .*expected two different places",
    ),
    "one body": (
        '["one.b", "two.a"]',
        '["one.b", "one.a"]',
        r"both are of body one; expected places of two bodies",
    ),
    "ground to ground": (
        '["ground.far", "two.b"]\nstiffness',
        '["ground.far", "ground.O"]\nstiffness',
        r"forces\.coil\.between = .*both are of the ground",
    ),
    "missing interface": (
        'at = "two.b"',
        'at = "two.bb"',
        r'forces\.push\.at = "two\.bb": body "two" has no interface "bb"; did you mean \'b\'',
    ),
    "negative mass": ("mass = 1.0", "mass = -1.0", r"bodies\.one\.mass = -1\.0: .*equal to 0"),
    "negative stiffness": (
        "stiffness = [1.0, 2.0, 3.0]",
        "stiffness = [1.0, -2.0, 3.0]",
        r"forces\.mount\.stiffness\.1 = -2\.0: .*greater than or equal to 0",
    ),
    "idle spring": ("stiffness = 100.0", "", r"forces\.coil: has no effect; expected stiffness"),
    "no such joint": (
        'joint = "hinge"',
        'joint = "hing"',
        r'signals\.turn\.joint = "hing": no such joint; did you mean \'hinge\'',
    ),
    "coordinate of another kind": (
        'coordinate = "angle"',
        'coordinate = "z"',
        r'signals\.turn\.coordinate = "z": joint hinge is revolute; expected angle',
    ),
    "treatment and integrator": (
        "t_end = 1.0",
        't_end = 1.0\nconstraints = "ggl"\nintegrator = "rk8"',
        r'solver\.constraints = "ggl" with integrator = "rk8": expected integrator',
    ),
}


@pytest.mark.parametrize("name", list(BAD))
def test_bad_input_exits_with_2_and_writes_nothing(name, tmp_path, capsys):
    old, new, expected = BAD[name]
    assert old in SOURCE
    file = tmp_path / "case.toml"
    file.write_text(SOURCE.replace(old, new, 1))
    out = tmp_path / "build"
    assert main(["check", str(file), "--out", str(out)]) == 2
    message = capsys.readouterr().err
    assert str(file) in message
    assert re.search(expected, message), message
    assert not out.exists()


def _built(tmp_path, source=SOURCE):
    """The model of a case, by way of the files that `check` writes."""
    file = tmp_path / "case.toml"
    file.write_text(source)
    write_case(load_case(file), tmp_path / "build")
    return build(read_run(tmp_path / "build/runs/base.json").mechanism, {})


def test_drives_follow_their_joints_and_count_from_the_start(tmp_path):
    built = _built(tmp_path)
    assert built.joint_names == [
        "hinge",
        "hinge (drive)",
        "cross",
        "sleeve",
        "sleeve (translation drive)",
    ]
    assert [built.joints[n].rows for n in ("hinge", "cross", "sleeve")] == [(0, 1), (2,), (3, 4)]
    model = built.model
    assert law_at(model, model.joint_law[1], 0.0)[0] == pytest.approx(0.3)
    assert law_at(model, model.joint_law[1], 0.5)[:2] == pytest.approx((0.3 + 0.5, 2.0))
    # two.b starts at (2, 0, 0), 0.5 m below the far point along the axis
    assert law_at(model, model.joint_law[4], 0.0)[0] == pytest.approx(-0.5)
    assert law_at(model, model.joint_law[4], 1.0)[0] == pytest.approx(-0.3)


def test_axes_of_a_cross(tmp_path):
    model = _built(tmp_path).model
    one, two = model.joint_marker[2]
    np.testing.assert_allclose(model.marker_A[one][:, 2], [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(model.marker_A[two][:, 0], [0.0, 0.0, 1.0], atol=1e-15)


def test_default_lengths_are_the_distances_at_the_start(tmp_path):
    source = SOURCE.replace(
        "[forces.coil]",
        '[joints.rod]\nkind = "distance"\nbetween = ["ground.far", "one.a"]\n\n[forces.coil]',
    )
    model = _built(tmp_path, source).model
    assert model.force_parameters[0, 2] == pytest.approx(np.sqrt(1.0 + 0.25))
    assert model.joint_parameters[5, 0] == pytest.approx(np.sqrt(9.25))


def test_direction_of_a_load_is_a_unit_vector(tmp_path):
    model = _built(tmp_path).model
    np.testing.assert_allclose(model.force_parameters[2, :3], [0.0, 1.0, 0.0])
    assert law_at(model, model.force_law[2], 0.5)[0] == pytest.approx(3.0)


def test_table_from_a_file_is_part_of_the_run(tmp_path):
    """The run holds the numbers; the case knows the file."""
    (tmp_path / "push.csv").write_text("t, F\n# newtons\n0, 0\n0.5, 4\n1.0, 1\n")
    source = SOURCE.replace(
        "times = [0.0, 0.5, 1.0], values = [0.0, 3.0, 1.0]", 'file = "push.csv"'
    )
    model = _built(tmp_path, source).model
    assert law_at(model, model.force_law[2], 0.5)[0] == pytest.approx(4.0)
    assert source_files(load_case(tmp_path / "case.toml")) == [tmp_path / "push.csv"]


def test_bad_line_of_a_file(tmp_path, capsys):
    (tmp_path / "push.csv").write_text("t, F\n0, 0\n0.5; 4\n")
    file = tmp_path / "case.toml"
    file.write_text(
        SOURCE.replace("times = [0.0, 0.5, 1.0], values = [0.0, 3.0, 1.0]", 'file = "push.csv"')
    )
    assert main(["check", str(file)]) == 2
    assert "push.csv line 3: expected two numbers with a comma" in capsys.readouterr().err


def test_distance_without_length(tmp_path, capsys):
    source = SOURCE.replace(
        "[forces.coil]",
        '[joints.rod]\nkind = "distance"\nbetween = ["ground.O", "one.a"]\n\n[forces.coil]',
    )
    file = tmp_path / "case.toml"
    file.write_text(source)
    out = tmp_path / "build"
    assert main(["check", str(file), "--out", str(out)]) == 0
    assert main(["run", str(out / "runs/base.json"), "--out", str(out / "base"), "--quiet"]) == 2
    assert "joints.rod: its places" in capsys.readouterr().err
