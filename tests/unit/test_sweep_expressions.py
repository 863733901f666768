"""Sweeps that reach descriptions: keys after a colon, expressions of named parameters."""

import json
import re
from pathlib import Path

import pytest
from samples.tube_samples import CARBON, CASE, TUBE

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import checked_case, load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.inputs.common.text_file import read_toml

SWEEP = """
[sweeps.s]
run = "base"
"""
FIRST = '"sections.tube:laminates.wall.angles_deg.0"'
SECOND = '"sections.tube:laminates.wall.angles_deg.1"'
PLY = '"sections.tube:laminates.wall.ply_thickness"'


def _load(folder, vary, set_="", more="", case=CASE):
    text = f"{case}{SWEEP}{more}\n[sweeps.s.vary]\n{vary}\n[sweeps.s.set]\n{set_}\n"
    file = folder / "case.toml"
    file.write_text(text)
    return load_case(file)


def _plies(spec):
    return spec.content["section"]["regions"]["wall"]["plies"]


def test_angles_follow_a_parameter_and_its_negative(tmp_path):
    case = _load(tmp_path, "angle = [0, 20, 45]", f'{FIRST} = "angle"\n{SECOND} = "-angle"')
    sweep = case.sweeps["s"]
    angles = [[p["angle_deg"] for p in _plies(bodies["arm"])] for bodies in sweep.own.bodies]
    assert angles == [[0, 0], [20, -20], [45, -45]]
    (parameter,) = sweep.parameters
    assert (parameter.name, parameter.unit) == ("angle", "deg")
    assert parameter.keys == [FIRST.strip('"'), SECOND.strip('"')]


def test_expressions_take_functions_parameters_of_the_case_and_the_name_t(tmp_path):
    set_ = f'{PLY} = "2*t*plus"\n"bodies.arm.length" = "sqrt(t / 1e-3)"'
    sweep = _load(tmp_path, "t = [0.25e-3, 1e-3]", set_).sweeps["s"]
    assert [_plies(b["arm"])[0]["thickness"] for b in sweep.own.bodies] == [0.5e-3, 2e-3]
    assert [each["bodies.arm.length"] for each in sweep.own.changes] == [0.5, 1.0]
    assert sweep.parameters[0].unit == ""  # of neither key alone


def test_distinct_packages_are_built_once_and_shared_with_the_run(tmp_path):
    vary = 'angle = [0, 30]\n"gravity.1" = [-1.0, -2.0, -3.0]'
    case = _load(tmp_path, vary, f'{FIRST} = "angle"\n{SECOND} = "-angle"')
    write_case(case, tmp_path / "build")
    table = json.loads((tmp_path / "build/sweeps/s.json").read_text())
    assert len(table["members"]) == 6
    # [30, -30] is the lay-up of the run
    assert sorted(Path(p["file"]).parent.name for p in table["packages"]) == ["bodies"] * 2
    assert {p["file"].split("/")[0] for p in table["packages"]} == {"bodies", "sweeps"}


def test_keys_of_a_described_file_and_of_a_shell(tmp_path, repository):
    (tmp_path / "tube.toml").write_text(f'format = 1\ntitle = "tube"{TUBE}{CARBON}')
    case = CASE.replace(
        f"[sections.tube.description]\n{TUBE}", '[sections.tube]\nfile = "tube.toml"'
    )
    sweep = _load(tmp_path, f"{SECOND} = [10, 20]", case=case).sweeps["s"]
    assert [_plies(b["arm"])[1]["angle_deg"] for b in sweep.own.bodies] == [10, 20]
    file = repository / "cases/double-pendulum-shell/case.toml"
    table = read_toml(file, "case file")
    (name, material), *_ = read_toml(file.with_name("hand.toml"), "shell")["materials"].items()
    key = f"bodies.hand:materials.{name}.rho"
    table["sweeps"] = {"s": {"run": "shell", "vary": {key: [material["rho"], 2000.0]}}}
    found = checked_case(table, file).sweeps["s"]
    assert [b["hand"].content["shell"]["materials"][name]["rho"] for b in found.own.bodies] == [
        material["rho"],
        2000.0,
    ]
    assert found.parameters[0].unit == "kg/m3"


def test_a_variant_changes_a_lay_up(tmp_path):
    more = '[variants.soft.sections.tube.changes]\n"laminates.wall.angles_deg" = [80, -80]\n'
    file = tmp_path / "case.toml"
    file.write_text(CASE + '[runs.soft]\nvariants = ["soft"]\n' + more)
    case = load_case(file)
    assert [p["angle_deg"] for p in _plies(case.bodies["base"]["arm"])] == [30, -30]
    assert [p["angle_deg"] for p in _plies(case.bodies["soft"]["arm"])] == [80, -80]


ANGLE = "angle = [0, 30]"
BAD = {
    "dots": (
        '"sections.tube.laminates.wall.angles_deg.0" = [1]',
        "",
        r'follows a colon, "sections.tube:laminates.wall.angles_deg.0"',
    ),
    "name": (ANGLE, f'{FIRST} = "-angel"', r"no name `angel`; did you mean 'angle'"),
    "code": (ANGLE, f'{FIRST} = "angle.real"', "is not allowed"),
    "call": (ANGLE, f'{FIRST} = "__import__(angle)"', "no function `__import__`"),
    "time": (ANGLE, f'{FIRST} = "angle + t"', "no parameter `t`"),
    "no parameter": (ANGLE, f'{FIRST} = "3 * plus"', "parameter of `vary`.* belongs in the case"),
    "not finite": (ANGLE, f'{FIRST} = "1 / angle"', "is not finite"),
    "a root": (ANGLE, f'{FIRST} = "sqrt(-angle)"', "finite value"),
    "twice": (f"{FIRST} = [0]\n{ANGLE}", f'{FIRST} = "angle"', "varied twice, by set and"),
    "unused": (ANGLE, "", r"angle: expected a dotted key"),
    "key": ('"sections.tube:laminates.wal.angles_deg.1" = [1]', "", "did you mean 'wall'"),
    "place": ('"sections.tube:laminates.wall.angles_deg.2" = [1]', "", "known: 0, 1"),
    "owner": ('"sections.tub:laminates.wall.angles_deg.1" = [1]', "", "did you mean 'sections.tub"),
    "joint": ('"joints.hinge:axis.0" = [1]', "", "described section or a shell before the colon"),
    "text": ('"sections.tube:laminates.wall.material" = [1]', "", "this is text"),
    "bounds": (
        f"{FIRST} = [20, 95]",
        "",
        r"wall\.angles_deg\.0 = 95.*member 1: .*angles_deg.0 = 95\)",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_wrong_keys_and_expressions(name, tmp_path):
    vary, set_, expected = BAD[name]
    with pytest.raises(InputError) as error:
        _load(tmp_path, vary, set_)
    (line,) = str(error.value).splitlines()
    assert "case.toml: sweeps.s" in line
    assert re.search(expected, line), line


def test_one_mistake_of_a_lay_up_is_one_message(tmp_path):
    """Two runs, a sweep of 30 members and a coarse variant share a wrong material."""
    more = "[runs.other]\n[coarse]\nsolver.t_end = 0.05\n"
    case = CASE.replace('material = "carbon", angles', 'material = "carbn", angles') + more
    vary = f"{FIRST} = {{ from = 0, to = 29, count = 30 }}"
    with pytest.raises(InputError) as error:
        _load(tmp_path, vary, case=case)
    (line,) = str(error.value).splitlines()
    key = "sections.tube.description.laminates.wall"
    assert line.endswith(f"{key} = \"carbn\": no such material; did you mean 'carbon'?")


def test_angles_of_a_lay_up_as_text_are_no_numbers(tmp_path):
    case = CASE.replace("angles_deg = [30, -30]", 'layup = "[30/-30]"')
    assert case != CASE
    with pytest.raises(InputError, match="`layup` is text: write angles_deg in its place"):
        _load(tmp_path, f"{FIRST} = [1]", case=case)
