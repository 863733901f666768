"""The resolved mechanism: from a run file and back, and with other values."""

import json
import math

import pytest
from case_samples import HEAD, SOLVER, rigid

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case import load_case
from plymotion.solver.inputs.case.resolved import resolved
from plymotion.solver.inputs.case.specs import write_case
from plymotion.solver.run.execution import read_run

LOAD = """
[forces.push]
kind = "force"
at = "ball.c"
direction = [1.0, 0.0, 0.0]
law = { table = { file = "push.csv" } }
"""


@pytest.fixture
def run(tmp_path):
    (tmp_path / "push.csv").write_text("t, F\n0.0, 0.0\n1.0, 2.0\n")
    text = HEAD + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)}) + LOAD
    (tmp_path / "case.toml").write_text(text + SOLVER.format(t_end=1.0, step=0.1, more=""))
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    return tmp_path / "build/runs/base.json"


def test_a_run_file_is_read_as_it_was_written(run):
    """A law from a file as well: it is read by `check`, not by the run."""
    (run.parents[2] / "push.csv").unlink()
    mechanism = read_run(run).mechanism
    assert mechanism.model_dump() == json.loads(run.read_text())["mechanism"]
    assert mechanism.forces["push"].law.table.values == [0.0, 2.0]


def test_keys_that_an_older_file_lacks_take_their_defaults(run):
    table = json.loads(run.read_text())
    del table["mechanism"]["solver"]["geometric_stiffening"]
    run.write_text(json.dumps(table))
    assert read_run(run).mechanism.solver.geometric_stiffening is False


def test_a_damaged_run_file_says_where(run):
    table = json.loads(run.read_text())
    table["mechanism"]["solver"]["t_ende"] = 3
    run.write_text(json.dumps(table))
    with pytest.raises(InputError, match=r"base\.json: solver\.t_ende: unknown key.*t_end"):
        read_run(run)


def test_other_values_are_checked(run):
    spec = read_run(run)
    other = spec.changed({"solver.t_end": 2.0, "bodies.ball.position.1": 0.5})
    assert other.mechanism.solver.t_end == 2.0
    assert other.mechanism.bodies["ball"].position == [0.0, 0.5, 0.0]
    assert spec.mechanism.solver.t_end == 1.0
    for value in (-1.0, math.nan, "long"):
        with pytest.raises(InputError, match=r"solver\.t_end"):
            spec.changed({"solver.t_end": value})


def test_nothing_is_no_mechanism():
    with pytest.raises(InputError, match=r"here: bodies: missing"):
        resolved({}, "here")
