"""A mechanism as an FMU in fmpy: description, path against our own run, calls out of turn."""

import ctypes
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from case_samples import HEAD, SOLVER, rigid, run_case
from exchange_routes import PROGRAMS

from plymotion.solver.__main__ import main
from plymotion.solver.commands.exchange.fmu.write import LIBRARY
from plymotion.solver.math.arrays import Array

STEP, T_END = 1e-3, 0.5  # [s]
OF_MODEL_EXCHANGE = {
    "fmi2EnterEventMode",
    "fmi2NewDiscreteStates",
    "fmi2EnterContinuousTimeMode",
    "fmi2CompletedIntegratorStep",
    "fmi2SetTime",
    "fmi2SetContinuousStates",
    "fmi2GetDerivatives",
    "fmi2GetEventIndicators",
    "fmi2GetContinuousStates",
    "fmi2GetNominalsOfContinuousStates",
}
SLIDER = (
    rigid("box", 2.0, 0.1, {"c": [0, 0, 0]}, position=[0.5, 0, 0])
    + """
[ground.o]
position = [0.0, 0.0, 0.0]
[joints.rail]
kind = "prismatic"
between = ["ground.o", "box.c"]
axis = [1.0, 0.0, 0.0]
[forces.push]
kind = "force"
at = "box.c"
direction = [1.0, 0.0, 0.0]
law = { constant = 1.0 }
[signals.x]
kind = "position"
at = "box.c"
component = "x"
"""
)


@pytest.fixture(scope="module")
def fmpy() -> Iterator[Any]:
    """The package fmpy from the folder of the tests' programs."""
    if shutil.which(os.environ.get("CC") or "cc") is None:
        pytest.skip("no C compiler: an FMU needs one")
    if not (PROGRAMS / "python" / "fmpy").is_dir():
        pytest.skip("fmpy is not installed: make test-exchange downloads it")
    sys.path.insert(0, str(PROGRAMS / "python"))
    try:
        import fmpy
        import fmpy.fmi2
        import fmpy.validation

        yield fmpy
    finally:
        sys.path.remove(str(PROGRAMS / "python"))


def export(folder: Path, case: Path, *words: str) -> Path:
    """Write an FMU with the command; `build` goes to the folder."""
    out, here = folder / "mechanism.fmu", Path.cwd()
    os.chdir(folder)
    try:
        assert main(["export", str(case), "--to", "fmu", "-o", str(out), *words]) == 0
    finally:
        os.chdir(here)
    return out


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


@pytest.fixture(scope="module")
def slider(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mass on a rail, pushed by a force."""
    folder = tmp_path_factory.mktemp("slider")
    (folder / "case.toml").write_text(HEAD + SLIDER + SOLVER.format(t_end=1.0, step=0.01, more=""))
    return export(folder, folder / "case.toml")


def turned(t: Array) -> Array:
    """Angle of the hinge: the drive of the case."""
    s = np.minimum(t / 0.4, 1.0)
    return np.asarray(-(10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5))


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


def test_path_is_that_of_our_own_run(fmpy: Any, arm: Path, own: dict[str, Array]) -> None:
    """Communication steps of 1 ms; fmpy starts from the angle and writes nothing but the angle."""
    t = np.linspace(0.0, T_END, 501)
    rows = np.array(list(zip(t, turned(t), strict=True)), dtype=[("time", float), ("u", float)])
    rows.dtype.names = ("time", "joints.hinge.drive")
    found = fmpy.simulate_fmu(str(arm), stop_time=T_END, output_interval=STEP, input=rows)
    assert found["time"] == pytest.approx(t, abs=1e-12)
    for name, values in own.items():
        assert np.abs(found[f"signals.{name}"] - values).max() < 1e-5, name
    # Outputs are those of the end of a step: one step late they would be wrong by 1 mm.
    path = np.column_stack([own[f"tip_{axis}"] for axis in "xyz"])
    there = np.column_stack([found[f"signals.tip_{axis}"] for axis in "xyz"])
    assert np.linalg.norm(there[1:] - path[:-1], axis=1).max() > 1e-3


def test_library_agrees_with_the_headers_of_the_standard(fmpy: Any, tmp_path: Path) -> None:
    """Declared as there, without a warning; every function of co-simulation is exported."""
    headers = Path(fmpy.__file__).parent / "c-code"
    out = tmp_path / "library.so"
    words = ["-std=gnu99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-parameter"]
    words += ["-D_GNU_SOURCE", "-DFMI2_HEADERS", f"-I{headers}", '-DGUID="x"']
    compiler = os.environ.get("CC") or "cc"
    command = [compiler, *words, "-shared", "-fPIC", str(LIBRARY), "-o", str(out), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    library = ctypes.CDLL(str(out))
    text = (headers / "fmi2Functions.h").read_text()
    names = set(re.findall(r"FMI2_Export \w+ +(fmi2\w+);", text))
    assert names >= OF_MODEL_EXCHANGE
    needed = names - OF_MODEL_EXCHANGE
    assert len(needed) == 34
    for name in needed:
        assert hasattr(library, name), name


class Instance:
    """An FMU that is called function by function; `told` is what it says."""

    def __init__(
        self, fmpy: Any, file: Path, folder: Path, name: str = "one", told: list[str] | None = None
    ) -> None:
        found = fmpy.read_model_description(str(file))
        unpacked = fmpy.extract(str(file), unzipdir=str(folder / name))
        self.vr = {v.name: v.valueReference for v in found.modelVariables}
        self.told: list[str] = [] if told is None else told
        self.fmu = fmpy.fmi2.FMU2Slave(
            guid=found.guid,
            unzipDirectory=unpacked,
            modelIdentifier=found.coSimulation.modelIdentifier,
            instanceName=name,
        )
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._hear)
        callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self.fmu.instantiate(callbacks=callbacks)

    def _hear(self, environment: Any, name: Any, status: int, category: Any, text: bytes) -> None:
        self.told.append(text.decode())

    def begin(self, **values: float) -> None:
        """Initialise, with these inputs."""
        self.fmu.setupExperiment(startTime=2.0)
        self.fmu.enterInitializationMode()
        for name, value in values.items():
            self.fmu.setReal([self.vr[name]], [value])
        self.fmu.exitInitializationMode()

    def moved(self, force: float, count: int = 20) -> list[float]:
        """The place of the box at the end of each step."""
        out = []
        for k in range(count):
            self.fmu.setReal([self.vr["forces.push"]], [force])
            self.fmu.doStep(2.0 + 0.01 * k, 0.01)
            out.append(self.fmu.getReal([self.vr["signals.x"]])[0])
        return out

    def close(self) -> None:
        self.fmu.freeInstance()


def test_two_instances_at_once_and_a_second_run(fmpy: Any, slider: Path, tmp_path: Path) -> None:
    """x = 0.5 + F t^2 / 2 m; time begins at 2 s."""
    one, two = (Instance(fmpy, slider, tmp_path, name) for name in ("one", "two"))
    for instance, force in ((one, 4.0), (two, -6.0)):
        instance.begin(**{"forces.push": force})
        assert instance.fmu.getReal([instance.vr["signals.x"]])[0] == pytest.approx(0.5, abs=1e-12)
    t = 0.01 * np.arange(1, 21)
    first, other = one.moved(4.0), two.moved(-6.0)
    assert first == pytest.approx(0.5 + 4.0 * t**2 / 4.0, abs=1e-10)
    assert other == pytest.approx(0.5 - 6.0 * t**2 / 4.0, abs=1e-10)
    one.fmu.reset()
    assert one.fmu.getReal([one.vr["forces.push"]]) == [1.0]
    one.begin(**{"forces.push": 4.0})
    assert one.moved(4.0) == first
    for instance in (one, two):
        instance.fmu.terminate()
        instance.close()


def test_slopes_of_inputs_and_orders_of_polynomials(
    fmpy: Any, slider: Path, tmp_path: Path
) -> None:
    """F = 4 + 30 t exactly, by its slope, although force_order = 0 would hold it."""
    one = Instance(fmpy, slider, tmp_path)
    one.fmu.setInteger([one.vr["force_order"]], [0])
    one.begin(**{"forces.push": 4.0})
    push = [one.vr["forces.push"]]
    for k in range(20):
        one.fmu.setReal(push, [4.0 + 0.3 * k])
        one.fmu.setRealInputDerivatives(push, [1], [30.0])
        one.fmu.doStep(2.0 + 0.01 * k, 0.01)
    found, t = one.fmu.getReal([one.vr["signals.x"]])[0], 0.2
    assert found == pytest.approx(0.5 + t**2 + 2.5 * t**3, abs=1e-10)
    one.close()


def test_calls_out_of_turn_are_refused_with_words(fmpy: Any, slider: Path, tmp_path: Path) -> None:
    one = Instance(fmpy, slider, tmp_path)
    x, push = one.vr["signals.x"], one.vr["forces.push"]
    error = fmpy.fmi1.FMICallException
    with pytest.raises(error):
        one.fmu.doStep(2.0, 0.01)
    one.begin()
    calls: list[tuple[Any, tuple[Any, ...], str]] = [
        (one.fmu.setReal, ([x], [1.0]), "fmi2SetReal: not an input"),
        (one.fmu.setReal, ([push], [np.nan]), "fmi2SetReal: expected a finite number"),
        (one.fmu.getReal, ([99],), "fmi2GetReal: no such value reference"),
        (one.fmu.setInteger, ([0], [1]), "fixed after the initialization"),
        (one.fmu.doStep, (3.0, 0.01), "expected to go on from where the last step has ended"),
        (one.fmu.doStep, (2.0, -0.01), "step size: expected above 0 s"),
        (one.fmu.setBoolean, ([0], [True]), "no Boolean variables"),
    ]
    for call, words, message in calls:
        with pytest.raises(error):
            call(*words)
        assert message in one.told[-1]
    assert one.moved(1.0, 1) == pytest.approx([0.5 + 0.25e-4], abs=1e-12)  # it goes on
    one.close()


def test_no_python_is_said(
    fmpy: Any, slider: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for python, message in (("/nowhere/python", "PLYMOTION_PYTHON"), ("/bin/true", "has ended")):
        monkeypatch.setenv("PLYMOTION_PYTHON", python)
        told: list[str] = []
        with pytest.raises(Exception, match="instantiate"):
            Instance(fmpy, slider, tmp_path, Path(python).name, told)
        assert message in told[-1]


def test_inputs_that_are_not_asked_for(arm: Path, repository: Path, tmp_path: Path) -> None:
    """The archive holds one run with its packages, and no path into the repository but one."""
    with zipfile.ZipFile(arm) as archive:
        names = archive.namelist()
        assert archive.read("resources/inputs.txt") == b"joints.hinge.drive\n"
        assert archive.read("resources/solver.txt").decode().splitlines()[0] == sys.executable
    assert "modelDescription.xml" in names
    assert "resources/bodies/arm.vtkhdf" in names
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
