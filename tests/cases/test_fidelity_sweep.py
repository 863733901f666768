"""Sweeps of a run with [fidelity]: one plan, made at the base, checked at members drawn."""

import json

import numpy as np
import pytest
from samples.fidelity_packages import CASE, build_bodies

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.results.codes import PLAN_TOO_COARSE
from plymotion.solver.studies.sweep.file import read_sweep

# A member of 60 kg needs more than the plan of the base in a longer run only.
LONG = CASE.replace("t_end = 0.1", "t_end = 0.3")
SWEEP = """
[sweeps.loads]
run = "base"
signals = ["tip"]
[sweeps.loads.vary]
"masses.load.mass" = [0.5, 1.0, 1.5, 2.0, 2.5]
"""


def made(root, text):
    """A checked case with its packages; the sweep file."""
    (root / "case.toml").write_text(text)
    assert main(["check", str(root / "case.toml"), "--out", str(root / "build")]) == 0
    for bodies in (root / "build/bodies", root / "build/sweeps/bodies"):
        build_bodies(bodies, bodies)
    return root / "build/sweeps/loads.json"


def sweep(file, *options):
    return main(["sweep", str(file), "--no-figures", *options])


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return made(tmp_path_factory.mktemp("sweep"), CASE + SWEEP)


def test_the_plan_is_made_once_and_checked_at_members(file, capsys):
    assert sweep(file, "--jobs", "1") == 0
    text = capsys.readouterr().out
    assert "plan at the base: accuracy 0.01 met" in text
    drawn = [entry["member"] for entry in json.loads(file.read_text())["fidelity"]["drawn"]]
    assert len(set(drawn)) == 3
    record = json.loads(file.with_suffix(".fidelity.json").read_text())
    assert [int(k) for k in record["members"]] == drawn
    for k, found in record["members"].items():
        assert f"checked at member {k} (masses.load.mass = " in text
        assert found["verdict"] == "met"
        assert 0.0 < found["estimate"]["tip"] < 1e-2
    rows = read_sweep(file.with_suffix("") / "sweep.h5").rows
    assert [row.status for row in rows] == ["finished"] * 5


def test_members_have_the_accuracy_of_the_check(file, capsys):
    """Largest values of all members against those of a run with all modes of the package."""
    sweep(file, "--jobs", "1")
    rows = read_sweep(file.with_suffix("") / "sweep.h5").rows
    tips = np.array([row.signals["tip"]["max"] for row in rows])
    plan = file.with_suffix(".plan.toml")
    rich = "\n".join(
        'vibrations = ["bending-xy 1", "bending-xy 2", "bending-xy 3", "axial 1"]'
        if line.startswith("vibrations")
        else "rtol = 1e-5"
        if line.startswith("rtol")
        else line
        for line in plan.read_text().splitlines()
    )
    kept = plan.read_text()
    plan.write_text(rich)
    assert sweep(file, "--jobs", "1") == 0
    again = read_sweep(file.with_suffix("") / "sweep.h5").rows
    plan.write_text(kept)
    exact = np.array([row.signals["tip"]["max"] for row in again])
    assert 0.0 < np.abs(tips - exact).max() < 1e-2 * np.abs(exact).max()


@pytest.mark.provokes("plan-too-coarse")
def test_a_member_that_needs_more_promotes_the_plan_of_all(tmp_path, capsys):
    """At the base the arm is rigid, with a mass of 60 kg it is not.

    A plan that the user makes rigid again is checked, not changed, and the member is told.
    """
    heavy = SWEEP.replace("[0.5, 1.0, 1.5, 2.0, 2.5]", "[1.0, 60.0]")
    file = made(tmp_path, LONG + heavy)
    assert sweep(file, "--jobs", "1") == 0
    assert PLAN_TOO_COARSE.name not in capsys.readouterr().out
    plan = file.with_suffix(".plan.toml")
    text = plan.read_text()
    assert "bending-xy 1" in text or "static_shapes = 0" not in text
    record = json.loads(file.with_suffix(".fidelity.json").read_text())
    assert record["members"]["1"]["estimate"]["tip"] < 1e-2
    changes = {"vibrations": "vibrations = []", "static_shapes": "static_shapes = 0"}
    rigid = [changes.get(line.partition(" ")[0], line) for line in text.splitlines()]
    plan.write_text("\n".join(rigid))
    assert sweep(file, "--jobs", "1") == 0
    told = capsys.readouterr().out
    assert PLAN_TOO_COARSE.name == "plan-too-coarse"
    assert (
        f"warning [{PLAN_TOO_COARSE.name}] the plan does not reach the accuracy at member 1: "
        in told
    )
    assert "2 computed" in told  # with the plan that was edited
    assert plan.read_text() == "\n".join(rigid)


def test_python_makes_the_plan_as_the_command_does(file, tmp_path):
    """Made a second time, the plan and its sweep are the same to the last digit."""
    assert sweep(file, "--jobs", "1") == 0
    case, ready = file.parents[2] / "case.toml", tmp_path / "ready"
    ready.mkdir()
    for bodies in (file.parents[1] / "bodies", file.parent / "bodies"):
        build_bodies(bodies, ready)
    found = pm.sweep(case, "loads", out=tmp_path / "out", packages=ready)
    assert found.status == ["finished"] * 5
    plan = tmp_path / "out/sweeps/loads.plan.toml"
    assert plan.read_text() == file.with_suffix(".plan.toml").read_text()
    command = read_sweep(file.with_suffix("") / "sweep.h5")
    assert found.signals["tip"].max.tolist() == command.signal("tip", "max").tolist()
