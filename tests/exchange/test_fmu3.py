"""FMI 3.0: what fmpy finds, the path, states to the last bit, derivatives, impacts as events."""

import os
import zipfile
from collections.abc import Iterator
from ctypes import c_double, c_uint32
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.case_samples import HEAD, rigid
from samples.fmu_samples import export, fmpy, solver

import plymotion as pm
from plymotion.solver.math.arrays import Array
from plymotion.solver.run.execution import execute, read_run

__all__ = ["fmpy"]  # fixture

# A ball of 0.1 m falls from 0.3 m onto a floor; Hertz, with a restitution.
BALL = (
    "gravity = [0.0, 0.0, -9.81]\n"
    + rigid("ball", 1.0, 0.01, {"c": [0, 0, 0]}, position=[0, 0, 0.3])
    + """
[ground.floor]
position = [0.0, 0.0, 0.0]
[forces.bounce]
kind = "contact"
between = ["ground.floor", "ball.c"]
axis = [0.0, 0.0, 1.0]
radius = 0.1
stiffness = 1e9
exponent = 1.5
restitution = 0.8
[forces.push]
kind = "force"
at = "ball.c"
direction = [0.0, 0.0, 1.0]
law = { constant = 0.0 }
[signals.z]
kind = "position"
at = "ball.c"
component = "z"
[signals.v]
kind = "velocity"
at = "ball.c"
component = "z"
"""
)


class Instance:
    """An FMU of version 3 that is called function by function, from t = 0."""

    def __init__(self, fmpy: Any, file: Path, folder: Path, **words: Any) -> None:
        import fmpy.fmi3

        found = fmpy.read_model_description(str(file))
        self.vr = {v.name: v.valueReference for v in found.modelVariables}
        self.outputs = [v.valueReference for v in found.modelVariables if v.causality == "output"]
        self.told: list[str] = []
        self.fmu = fmpy.fmi3.FMU3Slave(
            guid=found.instantiationToken,
            unzipDirectory=fmpy.extract(str(file), unzipdir=str(folder / "unpacked")),
            modelIdentifier=found.coSimulation.modelIdentifier,
            instanceName="one",
        )
        told = self.told
        self.fmu.instantiate(logMessage=lambda e, s, c, m: told.append(m.decode()), **words)
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()

    def step(self, k: int, h: float, **inputs: float) -> Array:
        """Outputs at the end of step k."""
        for name, value in inputs.items():
            self.fmu.setFloat64([self.vr[name.replace("__", ".")]], [value])
        self.fmu.doStep(k * h, h)
        return np.array(self.fmu.getFloat64(self.outputs))


def made(folder: Path, text: str) -> Path:
    """The FMU of a case."""
    (folder / "case.toml").write_text(HEAD + text + solver("radau"))
    return export(folder, folder / "case.toml", "--to", "fmu3")


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("ball"), BALL)


@pytest.fixture(scope="module")
def arm(repository: Path, tmp_path_factory: pytest.TempPathFactory, fmpy: Any) -> Iterator[Path]:
    """The flexible arm of cases/exchange, with tolerances by which stiff modes are resolved."""
    folder, here = tmp_path_factory.mktemp("arm"), Path.cwd()
    os.chdir(folder)
    case = pm.load(repository / "cases/exchange/case.toml").changed({"solver.rtol": 1e-7})
    ready = repository / "tests/packages/exchange"
    yield pm.export(case, "fmu3", folder / "arm.fmu", run="calculix-solid", packages=ready)
    os.chdir(here)


@pytest.fixture
def one(fmpy: Any, arm: Path, tmp_path: Path) -> Iterator[Instance]:
    found = Instance(fmpy, arm, tmp_path)
    yield found
    found.fmu.terminate()
    found.fmu.freeInstance()


def angle(t: float) -> float:
    s = min(t / 0.4, 1.0)
    return -(10 * s**3 - 15 * s**4 + 6 * s**5)


def test_fmpy_finds_nothing_wrong(fmpy: Any, arm: Path, ball: Path) -> None:
    for file in (arm, ball):
        assert fmpy.validation.validate_fmu(str(file)) == []
    found = fmpy.read_model_description(str(arm))
    can = found.coSimulation
    assert (found.fmiVersion, can.hasEventMode, can.canGetAndSetFMUstate) == ("3.0", True, True)
    flag = b'providesDirectionalDerivatives="true"'  # fmpy does not read it
    for file, able in ((arm, True), (ball, False)):
        with zipfile.ZipFile(file) as archive:
            assert (flag in archive.read("modelDescription.xml")) == able


def test_states_and_derivatives_of_a_flexible_arm(one: Instance, arm: Path) -> None:
    """A kept state gives the same bits; the path is ours; derivatives are its differences."""
    h, drive = 1e-3, [one.vr["joints.hinge.drive"]]
    for k in range(20):
        one.step(k, h, joints__hinge__drive=angle(k * h))
    state = one.fmu.getFMUState()
    found = []
    for _ in range(2):
        found.append([one.step(k, h, joints__hinge__drive=angle(k * h)) for k in range(20, 40)])
        one.fmu.setFMUState(state)
    assert np.array_equal(*found)
    spec = read_run(arm.parent / "build/exchange/runs/calculix-solid.json")
    result, _ = execute(spec.changed({"solver.t_end": 40 * h}), progress=False)
    assert result.t[1] == pytest.approx(h)
    path = np.array([signal.values for signal in result.signals]).T
    assert np.abs(np.array(found[0]) - path[21:]).max() < 1e-6
    ends = [one.step(20, h, joints__hinge__drive=angle(20 * h))]
    by = np.array(one.fmu.getDirectionalDerivative(one.outputs, drive, [1.0]))
    twice = np.array(one.fmu.getDirectionalDerivative(one.outputs, drive, [-2.0]))
    assert twice == pytest.approx(-2.0 * by, rel=1e-15)
    n = len(one.outputs)
    seed, back = np.arange(1.0, n + 1.0), (c_double * 1)()
    each = (c_uint32 * n)(*one.outputs), n, (c_uint32 * 1)(*drive), 1
    one.fmu.fmi3GetAdjointDerivative(one.fmu.component, *each, (c_double * n)(*seed), n, back, 1)
    assert back[0] == pytest.approx(float(seed @ by), rel=1e-14)
    for change in (1e-4, -1e-4):
        one.fmu.setFMUState(state)
        ends.append(one.step(20, h, joints__hinge__drive=angle(20 * h) + change))
    differences = (ends[1] - ends[2]) / 2e-4
    assert np.abs(by - differences).max() < 1e-6 * np.abs(differences).max()
    one.fmu.setFMUState(state)  # a derivative leaves the run where it is
    again = one.step(20, h, joints__hinge__drive=angle(20 * h))
    one.fmu.getDirectionalDerivative(one.outputs, drive, [1.0])
    assert np.array_equal(again, ends[0])
    behind = one.fmu.getFMUState()
    assert np.array_equal(one.step(21, h, joints__hinge__drive=angle(21 * h)), found[0][1])
    one.fmu.setFMUState(behind)  # a state has the derivatives of the step that led to it
    assert np.array_equal(one.fmu.getDirectionalDerivative(one.outputs, drive, [1.0]), by)
    for each in (state, behind):
        one.fmu.freeFMUState(each)


def test_impacts_are_events(fmpy: Any, ball: Path, tmp_path: Path) -> None:
    """At (2 (z - r) / g)^(1/2), from where the motion goes on as without events, and in fmpy."""
    one = Instance(fmpy, ball, tmp_path, eventModeUsed=True, earlyReturnAllowed=True)
    one.fmu.enterStepMode()
    fall, reached, events = (2.0 * 0.2 / 9.81) ** 0.5, 0.0, 0
    while reached < 0.3 - 1e-12:
        h = 0.05 * (np.floor(reached / 0.05 + 1e-9) + 1.0) - reached
        event, terminate, early, reached = one.fmu.doStep(reached, h)
        assert event == early
        assert not terminate
        if event:
            events += 1
            assert reached == pytest.approx(fall, abs=1e-9)
            v = one.fmu.getFloat64([one.vr["signals.v"]])[0]
            assert v == pytest.approx(-9.81 * fall, rel=1e-7)
            one.fmu.enterEventMode()
            assert one.fmu.updateDiscreteStates()[0] is False
            one.fmu.enterStepMode()
    assert events == 1
    end = one.fmu.getFloat64([one.vr["signals.z"]])[0]
    one.fmu.freeInstance()
    given: dict[str, Any] = {"stop_time": 0.3, "output_interval": 0.05}
    found = fmpy.simulate_fmu(str(ball), use_event_mode=True, early_return_allowed=True, **given)
    assert found["signals.z"][-1] == pytest.approx(end, abs=1e-9)
    assert found["time"][-1] == pytest.approx(0.3, abs=1e-12)
    # up again with 0.8 of the speed, once the contact of 1 ms is over
    up = 0.8 * 9.81 * fall * (0.3 - fall) - 0.5 * 9.81 * (0.3 - fall) ** 2
    assert end == pytest.approx(0.1 + up, abs=2e-3)


def test_a_force_jumps_in_event_mode_only_and_what_is_refused(
    fmpy: Any, ball: Path, tmp_path: Path
) -> None:
    """m z'' = F - m g: in step mode the line through the last two values, in event mode the new."""
    one = Instance(fmpy, ball, tmp_path, eventModeUsed=True)
    one.fmu.enterStepMode()
    h, z, push = 0.05, one.vr["signals.z"], one.vr["forces.push"]
    one.step(0, h, forces__push=2.0)
    state, ends = one.fmu.getFMUState(), []
    one.fmu.enterEventMode()
    one.fmu.setFloat64([push], [6.0])
    within = one.fmu.getFMUState()  # in event mode, behind the jump: a state that keeps it
    for kept in (state, within):
        one.fmu.setFMUState(kept)  # neither loses its jump, nor gets another one
        if kept is within:
            one.fmu.updateDiscreteStates()
            one.fmu.enterStepMode()
        ends.append(one.step(1, h, forces__push=6.0)[0])
    jump = 0.3 - 9.81 * (2 * h) ** 2 / 2 + 2.0 * h**2 / 2 + 2.0 * h * h + 6.0 * h**2 / 2
    assert ends[1] == pytest.approx(jump, abs=1e-9)
    assert ends[0] == pytest.approx(jump + 4.0 / h * h**3 / 6, abs=1e-9)
    calls: list[tuple[Any, tuple[Any, ...], str]] = [
        (one.fmu.enterStepMode, (), "fmi3EnterStepMode: called out of turn"),
        (one.fmu.setFloat64, ([z], [1.0]), "fmi3SetFloat64: not an input"),
        (one.fmu.getInt8, ([z],), "no variables of this type"),
        (one.fmu.getDirectionalDerivative, ([push], [push], [1.0]), "unknowns: expected outputs"),
        (one.fmu.getDirectionalDerivative, ([z], [push], [1.0]), "forces.bounce"),
    ]
    for call, words, message in calls:
        with pytest.raises(fmpy.fmi1.FMICallException):
            call(*words)
        assert message in one.told[-1]
    one.step(2, h)  # it goes on
    one.fmu.freeInstance()
