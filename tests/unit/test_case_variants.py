"""Variants that change kinds, bodies taken as rigid, and messages that name run and variant."""

import pytest
from samples.tube_samples import CASE

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case

RIGID = """
[runs.stiff]
variants = ["stiff"]
[variants.stiff.bodies.arm]
kind = "rigid"
mass = 2.0
inertia = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]
[variants.stiff.bodies.arm.interfaces]
root = { position = [0.0, 0.0, 0.0] }
"""


def _load(folder, text):
    file = folder / "case.toml"
    file.write_text(text)
    return load_case(file)


def test_a_beam_becomes_rigid_and_keeps_where_it_starts(tmp_path):
    placed = CASE.replace("length = 1.0\n", "length = 1.0\nposition = [1.0, 2.0, 3.0]\n")
    case = _load(tmp_path, placed + RIGID)
    body = case.runs["stiff"].bodies["arm"]
    assert (body.kind, body.mass, body.position) == ("rigid", 2.0, [1.0, 2.0, 3.0])
    assert list(body.interfaces) == ["root"]
    assert case.runs["base"].bodies["arm"].kind == "beam"


def test_a_joint_and_a_section_change_their_kind(tmp_path):
    more = """
[runs.other]
variants = ["other"]
[variants.other]
joints.hinge.kind = "spherical"
sections.tube = { shape = "tube", outer_radius = 0.02, wall = 0.001 }
bodies.arm.material = "carbon"
"""
    driven = CASE.replace("axis = [0.0, 0.0, 1.0]\n", "axis = [0, 0, 1]\ndrive = { speed = 1.0 }\n")
    case = _load(tmp_path, driven + more)
    joint = case.runs["other"].joints["hinge"]
    assert (joint.kind, joint.between) == ("spherical", ["ground.hinge", "arm.root"])
    assert case.runs["other"].sections["tube"].shape == "tube"
    assert case.runs["base"].joints["hinge"].drive.speed == 1.0


def test_the_same_kind_keeps_every_key(tmp_path):
    more = '[runs.o]\nvariants = ["o"]\n[variants.o.bodies.arm]\nkind = "beam"\nlength = 2.0\n'
    arm = _load(tmp_path, CASE + more).runs["o"].bodies["arm"]
    assert (arm.length, arm.section, list(arm.interfaces)) == (2.0, "tube", ["root", "tip"])


WRONG = '[variants.long.bodies.arm]\nlength = -1.0\n[runs.a]\nvariants = ["long"]\n'


def test_a_mistake_of_a_variant_names_run_and_variant(tmp_path):
    with pytest.raises(InputError) as error:
        _load(tmp_path, CASE + WRONG)
    (line,) = str(error.value).splitlines()
    assert "bodies.arm.length = -1.0: value should be greater than 0" in line
    assert line.endswith("(run a, variant long)")


def test_a_mistake_of_a_variant_that_no_run_has_is_told(tmp_path):
    """Unless the variant fits to one run at least."""
    unused = WRONG.split("[runs.a]")[0]
    with pytest.raises(InputError) as error:
        _load(tmp_path, CASE + unused)
    (line,) = str(error.value).splitlines()
    assert "bodies.arm.length = -1.0: value should be greater than 0" in line
    assert line.endswith("(variant long, of no run)")
    _load(
        tmp_path,
        CASE + RIGID + "[variants.heavy.bodies.arm]\ninertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n",
    )


def test_runs_with_the_same_variant_share_one_message(tmp_path):
    more = '[variants.v]\n[runs.b]\nvariants = ["v", "long"]\n[runs.c]\nvariants = ["long"]\n'
    with pytest.raises(InputError) as error:
        _load(tmp_path, CASE + WRONG + more)
    (line,) = str(error.value).splitlines()
    assert line.endswith("(run a, variant long; also b, c)")


def test_a_mistake_of_all_runs_names_none(tmp_path):
    with pytest.raises(InputError) as error:
        _load(tmp_path, CASE.replace("length = 1.0", "length = -1.0") + "[runs.more]\n")
    (line,) = str(error.value).splitlines()
    assert line.endswith("value should be greater than 0")


def test_a_kind_that_is_no_word_is_a_mistake_of_the_variant(tmp_path):
    more = '[runs.o]\nvariants = ["o"]\n[variants.o.joints.hinge]\nkind = ["revolute"]\n'
    with pytest.raises(InputError, match=r"joints\.hinge"):
        _load(tmp_path, CASE + more)
