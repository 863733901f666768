"""Joints by their free directions: the kind and the axis that leave just these."""

import pytest

from plymotion.solver.dynamics.elements.joints.contract import FREEDOMS
from plymotion.solver.dynamics.elements.joints.table import JOINTS
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case

CASE = """
format = 1
title = "block"
[bodies.block]
kind = "rigid"
mass = 1.0
inertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
interfaces = {{ c = {{ position = [0.0, 0.0, 0.0] }} }}
[ground.o]
position = [0.0, 0.0, 0.0]
[joints.j]
between = ["ground.o", "block.c"]
free = {free}
{more}
[solver]
t_end = 0.1
output_step = 0.1
[runs.base]
"""


def joint(tmp_path, free, more=""):
    file = tmp_path / "case.toml"
    file.write_text(CASE.format(free=free, more=more))
    return load_case(file).runs["base"]


@pytest.mark.parametrize(
    ("free", "kind", "axis"),
    [
        ([], "fixed", None),
        (["rz"], "revolute", [0, 0, 1]),
        (["ry"], "revolute", [0, 1, 0]),
        (["x"], "prismatic", [1, 0, 0]),
        (["y", "ry"], "cylindrical", [0, 1, 0]),
        (["rx", "ry", "rz"], "spherical", None),
        (["y", "z", "rx"], "planar", [1, 0, 0]),
        (["x", "rx", "ry", "rz"], "point_on_line", [1, 0, 0]),
    ],
)
def test_the_kind_leaves_just_these_free(tmp_path, free, kind, axis):
    found = joint(tmp_path, free).joints["j"]
    assert found.kind == kind
    assert getattr(found, "axis", None) == axis
    held = len(JOINTS[kind].removes)
    assert held + len(free) == len(FREEDOMS)


def test_other_keys_are_those_of_the_kind(tmp_path):
    more = 'drive = { speed = 2.0 }\n[signals.q]\nkind = "joint"\njoint = "j"\n'
    found = joint(tmp_path, ["rx"], more)
    assert found.joints["j"].drive.speed == 2.0
    assert found.signals["q"].coordinate == "angle"


@pytest.mark.parametrize(
    ("free", "more", "message"),
    [
        (["x", "y"], "", "no joint leaves just these free"),
        (["z", "rx"], "", "no joint leaves just these free"),
        (["a"], "", "expected some of x, y, z, rx, ry, rz"),
        ('"x"', "", "expected some of x, y, z, rx, ry, rz"),
        (["rz"], "axis = [0.0, 0.0, 1.0]", "expected no `axis` with `free`"),
        (["rz"], "translation_drive = { speed = 1.0 }", "joints.j.translation_drive: unknown key"),
    ],
)
def test_freedoms_without_a_joint_are_named(tmp_path, free, more, message):
    with pytest.raises(InputError) as error:
        joint(tmp_path, free, more)
    assert message in str(error.value)
