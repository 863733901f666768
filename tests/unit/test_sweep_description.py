"""[sweeps.NAME] of a case file: members, their bodies, and messages."""

import json
import re

import numpy as np
import pytest
from samples.sweep_samples import BALL, FORCE, MASS, ball, ball_plan

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.schema import Sweep, Variation
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.workers.packages import named_packages, needed_specs


def points(**table):
    return Sweep.model_validate({"run": "base", **table}).points()


def test_a_grid_has_all_combinations_the_first_parameter_slowest():
    found = points(vary={"a": [1, 2], "b": {"from": 0, "to": 1, "count": 3}})
    np.testing.assert_array_equal(found, [[1, 0], [1, 0.5], [1, 1], [2, 0], [2, 0.5], [2, 1]])


def test_a_list_takes_one_value_of_each():
    found = points(design="list", vary={"a": [1, 2], "b": [5, 7]})
    np.testing.assert_array_equal(found, [[1, 5], [2, 7]])


def test_a_latin_hypercube_has_one_point_in_each_slice():
    n = 16
    vary = {"a": {"from": -1, "to": 1}, "b": {"from": 10, "to": 30}, "c": [3, 5]}
    found = points(design="latin-hypercube", count=n, seed=4, vary=vary)
    for column, low, high in ((0, -1, 1), (1, 10, 30)):
        slices = np.floor((found[:, column] - low) / (high - low) * n).astype(int)
        assert sorted(slices) == list(range(n))
    assert np.count_nonzero(found[:, 2] == 3) == n // 2
    np.testing.assert_array_equal(
        found, points(design="latin-hypercube", count=n, seed=4, vary=vary)
    )
    assert np.any(found != points(design="latin-hypercube", count=n, seed=5, vary=vary))


def test_random_points_lie_in_their_ranges():
    found = points(design="random", count=200, vary={"a": {"from": 2, "to": 3}, "b": [1, 4]})
    assert found.shape == (200, 2)
    assert found[:, 0].min() >= 2
    assert found[:, 0].max() < 3
    assert set(found[:, 1]) == {1, 4}


def test_a_range_ends_where_it_says():
    assert Variation.model_validate({"from": 0, "to": 90, "count": 10}).listed()[-1] == 90


def test_members_are_the_mechanism_with_other_numbers(tmp_path):
    plan = ball_plan(tmp_path, f'{FORCE} = [2, 3]\n"bodies.ball.position.1" = [0.5]')
    assert [m.values for m in plan.members] == [(2, 0.5), (3, 0.5)]
    mechanism = plan.mechanism_of(1)
    assert mechanism.forces["push"].law.polynomial == [0, 0, 0, 3]
    assert mechanism.bodies["ball"].position == [0, 0.5, 0]
    assert plan.members[1].changes == {
        "forces.push.law.polynomial.3": 3,
        "bodies.ball.position.1": 0.5,
    }
    assert [p.unit for p in plan.parameters] == ["", "m"]


def test_one_parameter_may_have_several_keys(tmp_path):
    vary = 'both = { keys = ["bodies.ball.mass", "solver.t_end"], values = [1, 2] }'
    mechanism = ball_plan(tmp_path, vary).mechanism_of(1)
    assert mechanism.bodies["ball"].mass == mechanism.solver.t_end == 2


BAD = {
    "no such key": ('"bodies.ball.mas" = [1]', "", r"key bodies\.ball\.mas; did you mean 'mass'"),
    "no such body": ('"bodies.bal.mass" = [1]', "", r"key bodies\.bal; did you mean 'ball'"),
    "no such place": ('"gravity.3" = [1]', "", r"unknown key gravity\.3; known: 0, 1, 2"),
    "text": ('"forces.push.kind" = [1]', "", "expected the key of a number, this is text"),
    "table": ('"forces.push" = [1]', "", "expected the key of a number, this is a table"),
    "absent": ('"forces.push.law.table.x" = [1]', "", r"law\.table is absent in this run"),
    "below a number": ('"bodies.ball.mass.x" = [1]', "", r"bodies\.ball\.mass has no keys"),
    "bounds": (f"{MASS} = [1, -2]", "", r"bodies\.ball\.mass = -2: .*greater than or equal to 0"),
    "twice": (f"{MASS} = [1]\nm = {{ keys = [{MASS}], values = [1] }}", "", "varied twice"),
    "no count": (f"{MASS} = {{ from = 1, to = 2 }}", "", "expected `count` with"),
    "no end": (f"{MASS} = {{ from = 1, count = 2 }}", "", "expected `values`, or `from` and `to`"),
    "both": (f"{MASS} = {{ values = [1], to = 2 }}", "", "expected either `values` or"),
    "range key": (f"{MASS} = {{ form = 1 }}", "", "form: unknown key; did you mean 'from'"),
    "lists": (f"{MASS} = [1, 2]\n{FORCE} = [1]", 'design = "list"', "as many values of each"),
    "count of a grid": (f"{MASS} = [1, 2]", "count = 3", "expected no `count`"),
    "no count of points": (f"{MASS} = [1, 2]", 'design = "random"', "expected a `count`"),
    "signal": (f"{MASS} = [1]", 'signals = ["y"]', r's\.signals = "y": no such signal'),
    "history": (f"{MASS} = [1]", 'histories = ["xx"]', r"no such signal; did you mean 'x'"),
    "variant": (f"{MASS} = [1]", 'variants = ["w"]', r's\.variants = "w": no such variant'),
    "key": (f"{MASS} = [1]", "sed = 3", r"sweeps\.s\.sed: unknown key; did you mean 'seed'"),
    "no quotes": ("bodies.ball.mass = [1]", "", r"expected quotes around a dotted key, such as"),
    "times": ('"solver.t_end" = [1, 2]', 'histories = ["x"]', "expected none where solver.t_end"),
    "too many": (
        f"{MASS} = {{ from = 1, to = 2, count = 1000 }}\n{FORCE} = {{ from = 1, to = 2, count "
        "= 1000 }",
        "",
        "at most 100000 combinations",
    ),
}


@pytest.mark.parametrize("name", list(BAD))
def test_bad_sweeps_are_told_with_file_key_and_expectation(name, tmp_path):
    vary, more, expected = BAD[name]
    with pytest.raises(InputError) as error:
        ball(tmp_path, vary, more)
    message = str(error.value)
    assert str(tmp_path / "case.toml") in message
    assert "sweeps.s" in message
    assert re.search(expected, message), message
    assert not (tmp_path / "build").exists()


def test_no_such_run(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(BALL + f'[sweeps.s]\nrun = "bas"\n[sweeps.s.vary]\n{MASS} = [1]\n')
    with pytest.raises(InputError, match=r"sweeps\.s\.run = \"bas\": no such run; did you mean"):
        load_case(file)


def test_one_mistake_of_many_members_is_one_message(tmp_path):
    with pytest.raises(InputError) as error:
        ball(tmp_path, f"{MASS} = {{ from = -20, to = -1, count = 20 }}")
    (line,) = str(error.value).splitlines()
    assert "sweeps.s: bodies.ball.mass = -20: value should be greater than or equal to 0" in line
    assert line.endswith("(member 0: bodies.ball.mass = -20; and 19 more members)")


@pytest.fixture
def angles(repository, tmp_path):
    """The double pendulum with a sweep over ply angles and speeds, checked."""
    text = (repository / "cases/double-pendulum/case.toml").read_text()
    text = text[: text.index("[variants.fifth.solver]")]
    more = """
[sweeps.a]
run = "layup-1"
[sweeps.a.vary]
"bodies.hand.ply_angle_deg" = { from = 0, to = 45, count = 10 }
"joints.shoulder.drive.speed" = { from = 10, to = 20, count = 5 }
"""
    folder = tmp_path / "double-pendulum"
    folder.mkdir()
    (folder / "case.toml").write_text(text + more)
    return folder / "case.toml"


def test_a_body_is_specified_once_and_shared_with_runs(angles, tmp_path):
    out = tmp_path / "build"
    write_case(load_case(angles), out)
    table = json.loads((out / "sweeps/a.json").read_text())
    assert len(table["members"]) == 50
    assert len(table["packages"]) == 11  # ten hands and an arm
    files = [entry["file"] for entry in table["packages"]]
    # 0 deg is that of the run layup-1, 30 deg of the hand that of layup-2
    assert {f for f in files if f.startswith("bodies/")} == {
        "bodies/arm.layup-1.vtkhdf",
        "bodies/hand.layup-1.vtkhdf",
        "bodies/hand.layup-2.vtkhdf",
    }
    assert len(list((out / "sweeps/bodies").glob("hand.*.json"))) == 8
    needed = needed_specs({file: named_packages(file) for file in [out / "sweeps/a.json"]})
    assert all(spec.is_file() for specs in needed.values() for spec in specs)
    assert {folder: len(specs) for folder, specs in needed.items()} == {
        out / "bodies": 3,
        out / "sweeps/bodies": 8,
    }
    # a run waits for no body of a sweep
    runs = [out / "runs" / f"{run}.json" for run in load_case(angles).runs]
    assert list(needed_specs({run: named_packages(run) for run in runs})) == [out / "bodies"]


def test_more_values_leave_the_bodies_of_others_alone(angles, tmp_path):
    out = tmp_path / "build"
    write_case(load_case(angles), out)
    before = {p: p.stat().st_mtime_ns for p in (out / "sweeps/bodies").iterdir()}
    text = angles.read_text().replace("to = 45, count = 10", "to = 50, count = 11")
    angles.write_text(text)
    write_case(load_case(angles), out)
    now = {p: p.stat().st_mtime_ns for p in (out / "sweeps/bodies").iterdir()}
    assert before.items() <= now.items()
    assert len(now) == len(before) + 1


def test_coarse_sweeps(repository):
    case = load_case(repository / "cases/double-pendulum/case.toml", coarse=True)
    assert {name: len(sweep.points) for name, sweep in case.sweeps.items()} == {
        "layups": 4,
        "layup-speed": 4,
        "masses": 4,
    }
    assert case.sweeps["layups"].base.bodies["arm"].elements == 4
