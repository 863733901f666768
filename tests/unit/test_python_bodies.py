"""Shells, solids, packages and modes in Python have the numbers of the commands."""

import json

import numpy as np
import pytest
from samples.shell_file_samples import plate

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.package.shell.shell_file import write_shell


def printed(capsys, *words):
    """What a command prints as JSON."""
    capsys.readouterr()
    assert main([*map(str, words)]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def arm(repository):
    return repository / "cases/double-pendulum/case.toml"


@pytest.fixture(scope="module")
def packages(repository):
    return repository / "tests/packages/double-pendulum"


def test_a_shell_has_the_numbers_of_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_shell(tmp_path / "plate.vtkhdf", plate())
    shell = pm.shell("plate.vtkhdf")
    assert shell.numbers == printed(capsys, "shell", "plate.vtkhdf", "--json")
    assert shell.warnings[0]["code"] == "sliver-cells"
    assert "bending" in repr(shell)
    assert "<table>" in shell._repr_html_()


def test_wrong_descriptions_say_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "odd.toml").write_text("mesh = 1\n")
    for make in (pm.shell, pm.solid, pm.section):
        with pytest.raises(pm.InputError, match=r"odd\.toml"):
            make("odd.toml")
    with pytest.raises(pm.PackageError, match=r"gone\.vtkhdf"):
        pm.shell("gone.vtkhdf")


def test_modes_are_those_of_the_command(arm, packages, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["modes", arm, "--packages", packages, "--run", "isotropic"]
    words += ["--at", "equilibrium", "--json", "--shapes", 0]
    expected = printed(capsys, *words, "--out", tmp_path / "m")
    modes = pm.modes(pm.load(arm), "isotropic", at="equilibrium", packages=packages)
    assert modes.numbers == expected
    assert modes.frequencies.tolist() == [m["frequency_hz"] for m in expected["modes"]]
    linear = np.load(tmp_path / "m/linear.npz")
    assert np.array_equal(modes.system.A, linear["A"])
    assert not (tmp_path / "build").exists(), "nothing is written with ready packages"
    with pytest.raises(pm.InputError, match="no run 'nowhere'"):
        pm.modes(arm, "nowhere", packages=packages)
    with pytest.raises(pm.InputError, match="expected one speed"):
        pm.modes(arm, at="spin=0:1:0.5", packages=packages)


def test_info_validate_and_export_are_those_of_the_commands(repository, tmp_path, capsys):
    rod = repository / "tests/packages/slider-crank/rod.steel.vtkhdf"
    package = pm.info(rod)
    assert main(["info", str(rod)]) == 0
    shown = capsys.readouterr().out
    assert f"mass {package.mass:.6g} kg" in shown
    assert f"{package.frequencies[0]:12.5g} Hz" in shown
    assert [r for r in pm.validate(rod) if r.level == "error"] == []
    broken = tmp_path / "broken.vtkhdf"
    broken.write_bytes(rod.read_bytes()[:3000])
    assert pm.validate(broken)[0].level == "error"
    assert main(["export", str(rod), "--to", "mbdyn", "--out", str(tmp_path / "a.fem")]) == 0
    file = pm.export(rod, "mbdyn", tmp_path / "b.fem")
    assert file.read_bytes() == (tmp_path / "a.fem").read_bytes()
    with pytest.raises(pm.InputError, match="broken"):
        pm.export(broken, "mbdyn", tmp_path / "c.fem")
    with pytest.raises(pm.InputError, match=r'run: expected with to="fmu" or "fmu3" only'):
        pm.export(rod, "sid", tmp_path / "c.sid", run="base")
    assert not (tmp_path / "c.fem").exists()
