"""The resolved mechanism: from a run file and back, and with other values."""

import json
import math
from pathlib import Path

import pytest
from pydantic import BaseModel
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case import record
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.record import Record, seal, sealed
from plymotion.solver.inputs.case.tables.schema import Mechanism, resolved
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import read_run

LOAD = """
[forces.push]
kind = "force"
at = "ball.c"
direction = [1.0, 0.0, 0.0]
law = { table = { file = "push.csv" } }
"""

ROOT = Path(__file__).resolve().parents[2]
CASES = sorted(file.parent.name for file in ROOT.glob("cases/*/case.toml"))


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


def _same(record, model):
    """Compare all that is in a table, by the attributes and keys that the solver uses."""
    if isinstance(model, BaseModel):
        assert isinstance(record, Record)
        assert vars(record).keys() == type(model).model_fields.keys()
        for key in type(model).model_fields:
            _same(getattr(record, key), getattr(model, key))
    elif isinstance(model, dict):
        assert type(record) is dict
        assert list(record) == list(model)
        for key in model:
            _same(record[key], model[key])
    elif isinstance(model, list):
        assert len(record) == len(model)
        for one, other in zip(record, model, strict=True):
            _same(one, other)
    else:
        assert type(record) is type(model)
        assert record == model


@pytest.mark.parametrize("case", CASES)
def test_a_checked_file_is_read_as_the_models_would(repository, case):
    """Without the models, but with the same attributes and values."""
    for mechanism in load_case(repository / "cases" / case / "case.toml", sweeps=()).runs.values():
        table, found = json.loads(json.dumps([mechanism.model_dump(), seal(mechanism)]))
        record = sealed(table, found)
        _same(record, resolved(table, case))
        assert record.model_dump() == table


def test_an_edited_file_is_checked(run):
    """By whoever edits it: a seal belongs to one content."""
    assert isinstance(read_run(run).mechanism, Record)
    table = json.loads(run.read_text())
    table["mechanism"]["solver"]["t_end"] = 2.0
    run.write_text(json.dumps(table))
    assert isinstance(read_run(run).mechanism, Mechanism)
    table["mechanism"]["solver"]["t_end"] = -2.0
    run.write_text(json.dumps(table))
    with pytest.raises(InputError, match=r"base\.json: solver\.t_end"):
        read_run(run)


@pytest.mark.parametrize("found", [None, 3, {}, {"named": 3}, {"named": ["/bodies"], "sha256": ""}])
def test_a_seal_that_does_not_fit_is_none(run, found):
    table = json.loads(run.read_text())
    assert sealed(table["mechanism"], found) is None
    del table["checked"]["named"][0]
    assert sealed(table["mechanism"], table["checked"]) is None


def test_other_sources_check_a_file_again(run, monkeypatch):
    """They may have other keys and defaults."""
    monkeypatch.setattr(record, "solver_sha256", lambda: "other")
    assert isinstance(read_run(run).mechanism, Mechanism)
