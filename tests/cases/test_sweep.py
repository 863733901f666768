"""Sweeps from a case file to one file of results: restart, failures."""

import csv
import io
import json
from functools import partial

import h5py
import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, rigid
from samples.sweep_samples import FORCE, MASS, ball, ball_plan, checked, result, sweep

from plymotion.solver.__main__ import main
from plymotion.solver.results.codes import SPIN
from plymotion.solver.run.error_bars import with_error_bars
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.studies.sweep import portions
from plymotion.solver.studies.sweep.portions import compute
from plymotion.solver.studies.sweep.sweep_members import Packages

BRIEF = """
[variants.brief.solver]
t_end = 0.01
output_step = 0.002
error_bars = true
[sweeps.s]
run = "isotropic"
variants = ["brief"]
histories = ["tip_x", "hand_mid"]
[sweeps.s.vary]
"masses.M2.mass" = [1.5, 3.0]
"joints.shoulder.drive.speed" = [10.0, 20.0]
[runs.single]
variants = ["brief", "lighter"]
[runs.other]
variants = ["brief", "lighter", "still"]
[variants.still.bodies.hand]
rigid = true
[signals.gap]
kind = "difference"
of = "tip_x"
run = "other"
[variants.lighter]
masses.M2.mass = 1.5
joints.shoulder.drive.speed = 10.0
"""


@pytest.fixture
def computed(monkeypatch):
    """Numbers of the members that are computed, in order."""
    numbers: list[int] = []

    def watched(plan, packages, places, keys):
        numbers.extend(plan.members[k].number for k in places)
        return compute(plan, packages, places, keys)

    monkeypatch.setattr(portions, "compute", watched)
    return numbers


def pendulum(repository, folder):
    text = (repository / "cases/double-pendulum/case.toml").read_text()
    text = text[: text.index("[variants.fifth.solver]")] + BRIEF
    return checked(folder, text, repository / "tests/packages/double-pendulum")


def test_a_member_is_the_single_run_of_its_values(repository, tmp_path):
    """Bodies of packages, a drive, point masses: all signals, those of other runs too, whole
    history and error bars."""
    folder = pendulum(repository, tmp_path)
    assert sweep(folder / "s.json") == 0
    found = result(folder / "s.json")
    assert found.values.tolist() == [[1.5, 10], [1.5, 20], [3, 10], [3, 20]]
    spec, silent = read_run(folder.parent / "runs/single.json"), partial(execute, progress=False)
    single, summary = silent(spec)
    with_error_bars(summary, spec, single, silent)
    np.testing.assert_allclose(found.t, single.t, atol=1e-15)
    for s in single.signals:
        assert summary["signals"][s.name]["error_bar"] > 1e-8
        for measure in ("final", "min", "t_min", "max", "t_max", "error_bar"):
            expected = summary["signals"][s.name][measure]
            assert found.signal(s.name, measure)[0] == pytest.approx(expected, abs=1e-10)
        if s.name in ("tip_x", "hand_mid"):
            np.testing.assert_allclose(found.history(s.name)[0], s.values, rtol=0, atol=1e-10)
            assert np.ptp(found.history(s.name)[:, -1]) > 1e-5  # members differ
    assert found.rows[0].cost["evaluations"] == summary["cost"]["evaluations"]
    for name in ("constraint_position_max", "energy_drift_relative", "drive_work"):
        assert found.rows[0].checks[name] == pytest.approx(summary["checks"][name], rel=1e-9)


def test_the_ball_moves_as_it_must(tmp_path):
    """x = t + c t^5 / 20 m for a force c t^3 on 1 kg; twice the mass, half the push."""
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0, 4.0]\n{MASS} = [1.0, 2.0]", 'histories = ["x"]')
    assert sweep(file) == 0
    found = result(file)
    c, m = found.values.T
    np.testing.assert_allclose(found.signal("x", "final"), 1 + c / m / 20, atol=1e-9)
    np.testing.assert_allclose(found.signal("v", "max"), 1 + c / m / 4, atol=1e-9)
    expected = found.t + np.outer(c / m, found.t**5) / 20
    np.testing.assert_allclose(found.history("x"), expected, atol=1e-9)


def test_failed_members_do_not_stop_the_others(tmp_path, capsys):
    file = ball(tmp_path, f"{FORCE} = [1.0, 1e300, 2.0]", 'histories = ["x"]')
    assert sweep(file) == 3
    found = result(file)
    assert [row.status for row in found.rows] == ["finished", "failed", "finished"]
    assert "step" in found.rows[1].message
    assert found.rows[1].t_end < 1.0
    assert "run-failed" in found.rows[1].warnings
    history = found.history("x")
    assert np.isfinite(history[[0, 2]]).all()
    assert np.isnan(history[1]).any()
    out = capsys.readouterr().out
    assert "3 members, 2 finished, 1 failed" in out
    assert "forces.push.law.polynomial.3 = 1e+300: " in out


@pytest.mark.provokes("input")
def test_a_member_that_cannot_be_assembled_fails_alone(tmp_path, capsys):
    bar = {"a": (0, 0, 0), "b": (1, 0, 0)}
    text = HEAD + (
        rigid("left", 1.0, 0.1, bar, rotation_deg=[0, 0, 45])
        + rigid("right", 1.0, 0.1, bar, position=[0.7, 0.7, 0], rotation_deg=[0, 0, -45])
        + "[ground.a]\nposition = [0.0, 0.0, 0.0]\n[ground.b]\nposition = [1.4, 0.0, 0.0]\n"
        + "".join(
            f'[joints.{name}]\nkind = "{kind}"\nbetween = ["{one}", "{two}"]\n'
            for name, kind, one, two in (
                ("foot", "revolute", "ground.a", "left.a"),
                ("knee", "revolute", "left.b", "right.a"),
                ("far", "point_on_line", "ground.b", "right.b"),
            )
        )
        + '[signals.y]\nkind = "position"\nat = "left.b"\ncomponent = "y"\n'
        + SOLVER.format(t_end=0.1, step=0.1, more="")
        + '[sweeps.s]\nrun = "base"\n[sweeps.s.vary]\n'
        + '"ground.b.position.0" = [1.2, 2.5, 1.6, 2.6]\n'
    )
    file = checked(tmp_path, text) / "s.json"
    assert sweep(file) == 3
    found = result(file)
    assert [row.status for row in found.rows] == ["finished", "failed", "finished", "failed"]
    assert found.rows[1].code == "input"
    assert "cannot be assembled" in found.rows[1].message
    np.testing.assert_allclose(
        found.signal("y", "final")[[0, 2]], [np.sqrt(1 - 0.36), 0.6], atol=1e-8
    )
    assert np.isnan(found.signal("y", "final")[1])
    out = capsys.readouterr().out
    assert "failed [input] 2 members, first ground.b.position.0 = 2.5: " in out
    assert out.count("cannot be assembled") == 1


def test_spin_beyond_a_linear_body_stops_a_member(repository, tmp_path):
    text = (repository / "cases/double-pendulum-limits/case.toml").read_text()
    text += '[sweeps.s]\nrun = "layup-2-soft-following"\nvariants = ["s"]\n[sweeps.s.vary]\n'
    text += 'both = { keys = ["joints.shoulder.drive.speed", "bodies.hand.angular_velocity.2"], '
    text += "values = [1.0, 20.0] }\n[variants.s.solver]\n"
    text += 't_end = 0.01\noutput_step = 0.01\non_invalid = "stop"\n'
    file = checked(tmp_path, text, repository / "tests/packages/double-pendulum-limits") / "s.json"
    assert sweep(file) == 3
    rows = result(file).rows
    assert [row.status for row in rows] == ["finished", "stopped"]
    assert rows[1].code == SPIN.name
    assert "geometric_stiffening = true" in rows[1].message
    assert rows[1].t_end == 0.0


def test_what_is_there_is_not_computed_again(tmp_path, computed, capsys):
    file = ball(tmp_path, f"{FORCE} = [1.0, 1e300, 2.0]")
    assert sweep(file) == 3
    assert sorted(computed) == [0, 1, 2]
    computed.clear()
    before = result(file)
    assert sweep(file) == 3
    assert computed == []
    assert "0 computed" in capsys.readouterr().out
    ball(tmp_path, f"{FORCE} = [1.0, 1.5, 1e300, 2.0]")  # one value more
    assert sweep(file) == 3
    assert computed == [1]
    after = result(file)
    assert [after.rows[k] for k in (0, 3)] == [before.rows[k] for k in (0, 2)]
    computed.clear()
    assert sweep(file, "--fresh") == 3
    assert sorted(computed) == [0, 1, 2, 3]


def test_other_settings_are_other_members(tmp_path, computed):
    file = ball(tmp_path, f"{FORCE} = [1.0, 2.0]")
    assert sweep(file) == 0
    text = (tmp_path / "case.toml").read_text()
    checked(tmp_path, text.replace("rtol = 1e-10", "rtol = 1e-9"))
    computed.clear()
    assert sweep(file) == 0
    assert sorted(computed) == [0, 1]


def test_the_half_may_be_named(capsys):
    """`plymotion solver sweep`, as the folders are called."""
    for words in (["sweep"], ["solver", "sweep"]):
        with pytest.raises(SystemExit) as done:
            main([*words, "--help"])
        assert done.value.code == 0
        assert capsys.readouterr().out.startswith("usage: plymotion sweep")


@pytest.mark.provokes("defect")
def test_a_defect_is_told_and_the_others_go_on(tmp_path, monkeypatch):
    """An error that no input explains: its words in the row, the traceback for us."""
    from plymotion.solver.studies.sweep import portions

    prepare = portions.prepare

    def broken(*arguments, **options):
        if arguments[0].bodies["ball"].mass == 2:
            raise ZeroDivisionError("a defect")
        return prepare(*arguments, **options)

    monkeypatch.setattr(portions, "prepare", broken)
    plan = ball_plan(tmp_path, f"{MASS} = [1, 2, 3]")
    rows = compute(plan, Packages(plan), range(3), plan.keys())
    assert [row.status for row in rows] == ["finished", "failed", "finished"]
    assert rows[1].code == "defect"
    assert rows[1].message == "ZeroDivisionError: a defect"
    assert "broken" in rows[1].defect


def test_the_table_is_the_file(tmp_path, capsys):
    file = ball(tmp_path, f"{FORCE} = [1.0, 1e300]\n{MASS} = [1.0]")
    assert sweep(file, "--csv") == 3
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert (file.with_suffix("") / "sweep.csv").is_file()
    assert len(rows) == 2
    assert rows[0]["bodies.ball.mass [kg]"] == "1.0"
    assert float(rows[0]["x final [m]"]) == result(file).signal("x", "final")[0]
    assert rows[1]["status"] == "failed"
    assert rows[1]["message"]


def test_the_file_is_hdf5_that_says_what_it_holds(tmp_path):
    file = ball(tmp_path, f"{FORCE} = [1.0, 1e300]", 'histories = ["x"]')
    assert sweep(file) == 3
    with h5py.File(file.with_suffix("") / "sweep.h5") as h5:
        assert h5.attrs["format"] == b"plymotion sweep"
        assert h5["parameters/values"].shape == (2, 1)
        assert h5["parameters/name"].asstr()[0] == "forces.push.law.polynomial.3"
        assert list(h5["members/status"].asstr()) == ["finished", "failed"]
        assert h5["histories/x"].shape == (2, h5["histories/t"].size) == (2, 11)
        assert h5["signals/x"].attrs["unit"] == b"m"
        assert h5["signals/x/final"][0] == pytest.approx(1.05)


def test_a_damaged_file_is_computed_again(tmp_path, capsys):
    file = ball(tmp_path, f"{FORCE} = [1.0]")
    assert sweep(file) == 0
    h5 = file.with_suffix("") / "sweep.h5"
    h5.write_bytes(h5.read_bytes()[:1000])
    assert sweep(file) == 0
    assert "computed again" in capsys.readouterr().err
    assert result(file).rows[0].status == "finished"


def test_error_bars_need_no_run_of_signals_that_are_not_kept(repository, tmp_path):
    file = pendulum(repository, tmp_path) / "s.json"
    table = json.loads(file.read_text())
    table |= {"signals": ["tip_x"], "histories": [], "other_runs": {}}
    table["members"] = [table["members"][0] | {"other_runs": {}}]
    file.write_text(json.dumps(table))
    assert sweep(file) == 0
    assert result(file).signal("tip_x", "error_bar")[0] > 0.0


@pytest.mark.provokes("package")
def test_missing_packages(repository, tmp_path, capsys):
    """One that is missing fails its members; with none at all there is nothing to do."""
    folder = pendulum(repository, tmp_path)
    file = folder / "s.json"
    table = json.loads(file.read_text())
    table["packages"].append({**table["packages"][1], "file": "nowhere/hand.vtkhdf"})
    table["members"] = table["members"][:2]
    table["members"][1]["packages"]["hand"] = 2
    table["mechanism"]["solver"]["t_end"] = 0.002
    file.write_text(json.dumps(table))
    assert sweep(file) == 3
    rows = result(file).rows
    assert [row.status for row in rows] == ["finished", "failed"]
    assert rows[1].code == "package"
    assert "hand.vtkhdf: no such file" in rows[1].message
    assert "`plymotion packages` with the sweep file builds it" in rows[1].message
    table["packages"] = [{"file": "nowhere.vtkhdf"}] * 3
    file.write_text(json.dumps(table))
    capsys.readouterr()
    assert sweep(file) == 2
    message = capsys.readouterr().err
    assert "nowhere.vtkhdf: no such file, nor any other" in message
    assert f"`plymotion packages {file}` builds them" in message


@pytest.mark.parametrize("text", ["", "{}", '{"case": "x", "members": 3}', None])
def test_what_is_no_sweep_file(text, tmp_path, capsys):
    file = tmp_path / "s.json"
    if text is not None:
        file.write_text(text)
    assert sweep(file) == 2
    assert "not a sweep file" in capsys.readouterr().err
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize(
    ("vary", "shape"),
    [
        (f"{FORCE} = [1.0, 2.0, 1e300]", "curves"),
        (f"{FORCE} = [1.0, 2.0]\n{MASS} = [1, 2, 3]", "family"),
        (f"{FORCE} = {{ from = 1, to = 2, count = 7 }}\n{MASS} = [1, 2, 3, 4, 5, 6, 7]", "map"),
    ],
)
def test_figures(vary, shape, tmp_path, monkeypatch):
    from plymotion.solver.studies.sweep import sweep_outcome

    drawn = []
    for name in ("_curves", "_map", "_points"):
        real = getattr(sweep_outcome, name)
        monkeypatch.setattr(
            sweep_outcome,
            name,
            lambda *a, real=real, name=name: drawn.append((name, a)) or real(*a),
        )
    file = ball(tmp_path, vary, 'signals = ["x"]')
    assert main(["sweep", str(file), "--quiet"]) in (0, 3)
    assert (file.with_suffix("") / "x.png").stat().st_size > 10_000
    (name, arguments) = drawn[0]
    assert name == {"map": "_map"}.get(shape, "_curves")
    if shape == "family":
        assert arguments[2:] == (1, 0)  # along three masses, a curve for each of two forces


def test_points_of_a_drawn_design(tmp_path):
    more = 'design = "latin-hypercube"\ncount = 5\nsignals = ["x"]'
    vary = f"{FORCE} = {{ from = 1, to = 2 }}\n{MASS} = {{ from = 1, to = 2 }}"
    file = ball(tmp_path, vary, more)
    assert main(["sweep", str(file), "--quiet"]) == 0
    assert (file.with_suffix("") / "x.png").stat().st_size > 10_000
    found = result(file)
    c, m = found.values.T
    np.testing.assert_allclose(found.signal("x", "final"), 1 + c / m / 20, atol=1e-9)
