"""A mechanism as an FMU: description, path against our own run, archive, refusals."""

import re
import shutil
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, run_case
from samples.fmu_samples import SLIDER, export, fmpy, slider

from plymotion.solver.__main__ import main
from plymotion.solver.dynamics.elements.joints.table import COORDINATES
from plymotion.solver.math.arrays import Array
from plymotion.solver.signals import rotor
from plymotion.solver.signals.points import POINT_UNITS
from plymotion.solver.studies.fmu.write import UNITS

__all__ = ["fmpy", "slider"]  # fixtures


@pytest.fixture(scope="module")
def arm(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The arm of cases/exchange by CalculiX as an FMU."""
    ready = ["--packages", str(repository / "tests/packages/exchange")]
    case = repository / "cases/exchange/case.toml"
    return export(tmp_path_factory.mktemp("fmu"), case, "--run", "calculix-solid", *ready)


@pytest.fixture(scope="module")
def own(arm: Path) -> dict[str, Array]:
    """Signals of our own run, at the communication points."""
    return run_case(arm.parent / "build/exchange/runs/calculix-solid.json")[1]


def test_fmpy_finds_nothing_wrong_with_the_description(fmpy: Any, arm: Path, slider: Path) -> None:
    for file in (arm, slider):
        assert fmpy.validation.validate_fmu(str(file)) == []
    found = fmpy.read_model_description(str(arm))
    units = {v.name: (v.causality, v.unit) for v in found.modelVariables}
    assert units["joints.hinge.drive"] == ("input", "rad")
    assert units["signals.tip_z"] == ("output", "m")
    assert found.coSimulation.needsExecutionTool
    assert found.defaultExperiment.stopTime == "0.5"
    newton = next(
        u for u in fmpy.read_model_description(str(slider)).unitDefinitions if u.name == "N"
    )
    base = newton.baseUnit
    assert (base.kg, base.m, base.s) == (1, 1, -2)


def test_path_is_that_of_our_own_run(
    fmpy: Any,
    arm: Path,
    own: dict[str, Array],
    repository: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Communication steps of 1 ms, as the manual shows: the only input is the angle."""
    shutil.copy(arm, tmp_path / "arm.fmu")
    monkeypatch.chdir(tmp_path)
    page = (repository / "docs/fmu.md").read_text()
    (code,) = re.findall(r"^In fmpy:\n\n```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    names: dict[str, Any] = {}
    exec(code, names)
    found, t = names["result"], np.linspace(0.0, 0.5, 501)
    assert found["time"] == pytest.approx(t, abs=1e-12)
    for name, values in own.items():
        assert np.abs(found[f"signals.{name}"] - values).max() < 1e-5, name
    # Outputs are those of the end of a step: one step late they would be wrong by 1 mm.
    path = np.column_stack([own[f"tip_{axis}"] for axis in "xyz"])
    there = np.column_stack([found[f"signals.tip_{axis}"] for axis in "xyz"])
    assert np.linalg.norm(there[1:] - path[:-1], axis=1).max() > 1e-3


def test_inputs_that_are_not_asked_for(arm: Path, repository: Path, tmp_path: Path) -> None:
    """The archive holds one run with its packages, and no path into the repository but one."""
    with zipfile.ZipFile(arm) as archive:
        names = archive.namelist()
        assert archive.read("resources/inputs.txt") == b"joints.hinge.drive\n"
        assert archive.read("resources/solver.txt").decode().splitlines()[0] == sys.executable
    assert "modelDescription.xml" in names
    assert len([name for name in names if name.startswith("resources/bodies/")]) == 1
    case = repository / "cases/exchange/case.toml"
    ready = ["--packages", str(repository / "tests/packages/exchange"), "--run", "mystran"]
    bare = export(tmp_path, case, *ready, "--inputs")
    with zipfile.ZipFile(bare) as archive:
        assert archive.read("resources/inputs.txt") == b""
        assert b'causality="input"' not in archive.read("modelDescription.xml")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["case.toml", "--inputs", "forces.pull"], "forces.pull: no such input; expected some of"),
        (["case.toml", "--run", "bas"], "has no such run; did you mean 'base'?"),
        (["arm.vtkhdf"], "expected a case file, CASE.toml, with --to fmu"),
    ],
)
def test_refusals(
    slider: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    message: str,
) -> None:
    shutil.copy(slider.parent / "case.toml", tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["export", *words, "--to", "fmu"]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.rglob("*.fmu"))


def test_units_of_all_signals_are_those_of_fmi() -> None:
    """Of those that have one unit each; the power of a rotor was refused."""
    joints = {coordinate.unit for coordinate in COORDINATES.values()}
    assert joints | {*POINT_UNITS.values(), *rotor.UNITS.values(), "N", "N m", "Pa"} <= {*UNITS}


def test_python_files_of_a_case_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """An FMU is given away; a function of the user could do anything."""
    (tmp_path / "law.py").write_text("def law(t, inputs, memory):\n    return 0.0\n")
    control = """[forces.push]
kind = "python_controller"
joint = "rail"
sample_time = 0.01
code = { file = "law.py", function = "law" }
inputs = ["x"]
"""
    case = re.sub(r"\[forces\.push\].*?(?=\[signals)", control, SLIDER, flags=re.DOTALL)
    (tmp_path / "case.toml").write_text(HEAD + case + SOLVER.format(t_end=1.0, step=0.01, more=""))
    monkeypatch.chdir(tmp_path)
    code = main(["export", "case.toml", "--to", "fmu"])
    told = capsys.readouterr().err
    assert code == 2, told
    assert "forces.push.code: an FMU does not run Python files of the user" in told
    assert not list(tmp_path.rglob("*.fmu"))


def test_no_compiler_is_said(
    slider: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    shutil.copy(slider.parent / "case.toml", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CC", "/nowhere/cc")
    assert main(["export", "case.toml", "--to", "fmu"]) == 2
    assert "expected a C compiler" in capsys.readouterr().err
    assert not list(tmp_path.rglob("*.fmu"))
