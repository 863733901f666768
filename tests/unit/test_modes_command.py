"""The command `plymotion modes`: its files, its states, what it says of wrong input."""

import json
import re

import h5py
import numpy as np
import pytest
from samples.case_samples import rigid
from samples.modes_samples import write_case_text
from scipy.integrate import solve_ivp

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.commands import heartbeat
from plymotion.solver.package.common.files import RECORD
from plymotion.solver.studies.modes.state_modes import draw

SWING = (
    "gravity = [0.0, -9.81, 0.0]\n[ground.pin]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("rod", 2.0, 0.1, {"pin": (0, 0.5, 0), "end": (0, -0.5, 0)}, position=[0, -0.5, 0],
            angular_velocity=[0.0, 0.0, 1.0])
    + """
[joints.pin]
kind = "revolute"
between = ["ground.pin", "rod.pin"]
axis = [0.0, 0.0, 1.0]
"""
)  # fmt: skip


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return write_case_text(tmp_path, SWING)


def test_files_are_beside_those_of_the_run(case, capsys):
    pyvista = pytest.importorskip("pyvista")
    assert main(["modes", str(case), "--at", "equilibrium"]) == 0
    text = capsys.readouterr().out
    folder = case.parent.parent / "build/sample/modes/base-equilibrium"
    names = {file.name for file in folder.iterdir()}
    made = {"modes.json", "modes.png", "mode-01.vtkhdf", "linear.npz", "linear.mat"}
    assert names == {*made, RECORD}
    w = np.sqrt(2.0 * 9.81 * 0.5 / 0.6)
    assert f"{w / (2 * np.pi):.6g}" in text
    content = json.loads((folder / "modes.json").read_text())
    assert content["modes"][0]["angular_frequency"] == pytest.approx(w, rel=1e-9)
    assert pyvista.read(folder / "mode-01.vtkhdf").n_points > 0
    with h5py.File(folder / "mode-01.vtkhdf") as file:
        view = file["VTKHDF"]
        assert view["Steps/Values"][-1] == pytest.approx(2 * np.pi / w)
        moved = view["PointData/displacement"][()].reshape(25, -1, 3)
    # a quarter of a period apart, and back at the end
    assert np.abs(moved[6] - moved[0]).max() > 0.01
    np.testing.assert_allclose(moved[24], moved[0], atol=1e-12)


def test_a_time_of_the_run(case, capsys):
    """At an angle phi of the swing the stiffness is m g c cos(phi); a note says it is no rest."""
    assert main(["modes", str(case), "--at", "t=0.3", "--json", "--shapes", "0"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["t"] == 0.3
    assert any("no equilibrium" in note for note in content["notes"])
    w0 = np.sqrt(2.0 * 9.81 * 0.5 / 0.6)
    swing = solve_ivp(
        lambda _, y: [y[1], -(w0**2) * np.sin(y[0])], (0, 0.3), [0.0, 1.0], rtol=1e-10, atol=1e-12
    )
    w = content["modes"][0]["angular_frequency"]
    assert w == pytest.approx(w0 * np.sqrt(np.cos(swing.y[0, -1])), rel=1e-7)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--run", "bas"], "--run bas: .* no such run; did you mean 'base'"),
        (["--at", "t=7"], "--at t=7: expected a time from 0 to solver.t_end = 1 s"),
        (["--at", "t=-1"], "expected a time from 0"),
        (["--at", "equilibrum"], "--at equilibrum: expected start, equilibrium"),
        (["--at", "spin=x"], "'x' is not a number"),
        (["--at", "spin=5:1:1"], "expected FIRST below LAST"),
        (["--at", "spin=0:1e9:1"], "expected at most 2000"),
        (["--at", "spin=5", "--axis", "1,0,0"], "joint pin does not let the mechanism turn"),
        (["--at", "spin=5"], "loads are not constant in axes that turn"),
        (["--response", "5"], "--response 5: expected LOW:HIGH"),
        (["--response", "1:5"], "the case has no drive, load or actuator"),
        (["--packages"], None),
        (["--count", "0"], None),
    ],
)
def test_wrong_options_exit_with_2_and_words(case, capsys, options, words):
    try:
        code = main(["modes", str(case), *options])
    except SystemExit as ended:  # by argparse
        code = ended.code
    assert code == 2
    told = capsys.readouterr().err
    assert re.search(words or "expected", told)
    assert "Traceback" not in told


def test_spin_without_an_axis(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    case = write_case_text(tmp_path, rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)}))
    assert main(["modes", str(case), "--at", "spin=5"]) == 2
    assert "the axis of the spin is missing" in capsys.readouterr().err
    assert main(["modes", str(case), "--at", "spin=5", "--axis", "0,0,1"]) == 0


def test_a_diagram_is_drawn_where_its_lines_cross(repository, tmp_path):
    """A branch far above the harmonics is left out; labels beside the diagram lie apart."""
    text = (repository / "cases/rotor/case.toml").read_text("utf-8")  # 1P to 4P: 16 to 64 Hz
    case = tmp_path / "case.toml"
    case.write_text(text.replace("stiffness = [2e5, 2e5, 2e5]", "stiffness = [2e5, 2e5, 2e9]"))
    found = pm.campbell(case, [0.0, 100.0], harmonics=4)
    assert found.frequencies[:, 4] == pytest.approx(3559.0, rel=1e-3)
    drawn = draw(tmp_path / "campbell.svg", found._diagram).read_text("utf-8")
    assert "<!-- 1 more: campbell.csv -->" in drawn
    assert "rotor z" not in drawn
    labels = re.findall(r"<!-- (\S+) -->\s*<g [^>]*translate\(\S+ (\S+)\) scale\(0.08 ", drawn)
    assert sorted(text for text, _ in labels) == ["1", "1P", "2", "2P", "3", "3P", "4", "4P"]
    assert min(np.diff(sorted(float(height) for _, height in labels))) > 9.0  # [pt]


def test_it_says_that_it_works(case, capsys, monkeypatch):
    monkeypatch.setattr(heartbeat, "FIRST_S", 1e-3)
    for options, told in (([], True), (["--quiet"], False)):
        assert main(["modes", str(case), "--shapes", "0", *options]) == 0
        assert ("modes, 0 s" in capsys.readouterr().err) == told


def test_no_such_file(tmp_path, capsys):
    assert main(["modes", str(tmp_path / "case.toml")]) == 2
    assert "no such case file" in capsys.readouterr().err
