"""FMUs of two mechanisms, fmpy from the folder of the tests' programs, calls one by one."""

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from samples.case_samples import HEAD, SOLVER, rigid
from samples.exchange_routes import PROGRAMS

from plymotion.solver.__main__ import main

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


def solver(integrator: str) -> str:
    """The table `[solver]` with an integrator; `radau` has derivatives."""
    return SOLVER.replace("rk8", integrator).format(t_end=1.0, step=0.01, more="")


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
        to = () if "--to" in words else ("--to", "fmu")
        assert main(["export", str(case), *to, "-o", str(out), *words]) == 0
    finally:
        os.chdir(here)
    return out


@pytest.fixture(scope="module")
def slider(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mass on a rail, pushed by a force."""
    folder = tmp_path_factory.mktemp("slider")
    (folder / "case.toml").write_text(HEAD + SLIDER + solver("radau"))
    return export(folder, folder / "case.toml")


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
