"""The library of an FMU: the headers of the standard, programs in C and Python, wrong calls."""

import ctypes
import json
import os
import re
import socket
import struct
import subprocess
import sys
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.fmu_samples import Instance, fmpy, slider

from plymotion.solver.studies.fmu.server import START, STEP
from plymotion.solver.studies.fmu.write import LIBRARY, run_of

__all__ = ["fmpy", "slider"]  # fixtures

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


def test_library_agrees_with_the_headers_of_the_standard(fmpy: Any, tmp_path: Path) -> None:
    """Declared as there, without a warning; every function of co-simulation is exported."""
    headers = Path(fmpy.__file__).parent / "c-code"
    out = tmp_path / "library.so"
    words = ["-std=gnu99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-parameter"]
    words += ["-D_GNU_SOURCE", "-DFMI2_HEADERS", "-DFMI3_HEADERS", f"-I{headers}", '-DGUID="x"']
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
    text = (headers / "fmi3Functions.h").read_text()
    of_three = set(re.findall(r"FMI3_Export fmi3\w+TYPE +(fmi3\w+);", text))
    assert len(of_three) == 75
    for name in needed | of_three:
        assert hasattr(library, name), name


MASTER = """\
#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include "fmi2Functions.h"

static void told(fmi2ComponentEnvironment e, fmi2String who, fmi2Status s, fmi2String kind,
                 fmi2String text, ...)
{
    fprintf(stderr, "%s: %s\\n", who, text);
}

int main(int count, char **words)
{
    fmi2CallbackFunctions call = {told, calloc, free, 0, 0};
    fmi2ValueReference push = 0, x = 1;
    fmi2Real force = 4.0, place, one = 1.0;
    fmi2FMUstate saved = 0;
    assert(count == 2);
    assert(!fmi2Instantiate("a", fmi2CoSimulation, "of another", words[1], &call, 0, 0));
    fmi2Component c = fmi2Instantiate("a", fmi2CoSimulation, GUID, words[1], &call, 0, 0);
    assert(c);
    for (int run = 0; run < 2; run++) {
        assert(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK);
        assert(fmi2EnterInitializationMode(c) == fmi2OK);
        assert(fmi2SetReal(c, &push, 1, &force) == fmi2OK);
        assert(fmi2GetReal(c, &x, 1, &place) == fmi2OK && fabs(place - 0.5) < 1e-12);
        assert(fmi2ExitInitializationMode(c) == fmi2OK);
        for (int k = 0; k < 50; k++) {
            assert(fmi2SetReal(c, &push, 1, &force) == fmi2OK);
            assert(fmi2DoStep(c, 0.01 * k, 0.01, 1) == fmi2OK);
        }
        assert(fmi2GetFMUstate(c, &saved) == fmi2OK && saved);
        assert(fmi2DoStep(c, 0.5, 0.01, 1) == fmi2OK);
        assert(fmi2GetDirectionalDerivative(c, &x, 1, &push, 1, &one, &place) == fmi2OK);
        assert(fabs(place - 1e-4 / 3.0) < 1e-12); /* F + (F - F0) t / h: h^2 (1/2 + 1/6) / m */
        assert(fmi2GetDirectionalDerivative(c, &push, 1, &push, 1, &one, &place) == fmi2Error);
        assert(fmi2SetFMUstate(c, saved) == fmi2OK);
        assert(fmi2GetFMUstate(c, &saved) == fmi2OK); /* in the same place */
        if (run == 1) assert(fmi2FreeFMUstate(c, &saved) == fmi2OK && !saved);
        assert(fmi2DoStep(c, 0.9, 0.01, 1) == fmi2Error);
        assert(fmi2GetReal(c, &x, 1, &place) == fmi2OK && fabs(place - 0.75) < 1e-9);
        assert(fmi2Terminate(c) == fmi2OK);
        assert(fmi2DoStep(c, 0.5, 0.01, 1) == fmi2Error);
        assert(fmi2Reset(c) == fmi2OK);
    }
    fmi2FreeInstance(c);
    puts("done");
    return 0;
}
"""


def test_a_master_in_c_finds_no_slip_of_memory(fmpy: Any, slider: Path, tmp_path: Path) -> None:
    """The library inside a program that checks addresses, leaks and undefined behaviour."""
    headers = Path(fmpy.__file__).parent / "c-code"
    (tmp_path / "master.c").write_text(MASTER)
    checks = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"]
    with zipfile.ZipFile(slider) as archive:
        archive.extractall(tmp_path)
    guid = fmpy.read_model_description(str(slider)).guid
    program = tmp_path / "master"
    words = [os.environ.get("CC") or "cc", *checks, "-D_GNU_SOURCE", "-DFMI2_HEADERS"]
    words += [f"-I{headers}", f'-DGUID="{guid}"', str(tmp_path / "master.c"), str(LIBRARY)]
    made = subprocess.run([*words, "-o", str(program), "-lm"], capture_output=True, text=True)
    if made.returncode != 0 and ("libasan" in made.stderr or "libubsan" in made.stderr):
        pytest.skip(f"no sanitizers: {made.stderr.strip()[-200:]}")
    assert made.returncode == 0, made.stderr
    resources = (tmp_path / "resources").as_uri()
    done = subprocess.run([str(program), resources], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout == "done\n"


def test_two_instances_at_once_and_a_second_run(fmpy: Any, slider: Path, tmp_path: Path) -> None:
    """x = 0.5 + F t^2 / 2 m; time begins at 2 s."""
    one, two = (Instance(fmpy, slider, tmp_path, name) for name in ("one", "two ü 50%"))
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
        (one.fmu.setInteger, ([one.vr["force_order"]], [1]), "fixed after the initialization"),
        (one.fmu.doStep, (3.0, 0.01), "expected to go on from where the last step has ended"),
        (one.fmu.doStep, (np.nan, 0.01), "expected to go on from where the last step has ended"),
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
    message = "expected a Python with plymotion: set PLYMOTION_PYTHON"
    for python in ("/nowhere/python", "/bin/true"):
        monkeypatch.setenv("PLYMOTION_PYTHON", python)
        told: list[str] = []
        with pytest.raises(Exception, match="instantiate"):
            Instance(fmpy, slider, tmp_path, Path(python).name, told)
        assert message in told[-1]


def test_solver_ends_with_its_importer_in_the_middle_of_a_step(
    fmpy: Any, slider: Path, tmp_path: Path
) -> None:
    """A step of 1e9 steps of the integrator is under way when the other end closes."""
    with zipfile.ZipFile(slider) as archive:
        archive.extractall(tmp_path)
    file = run_of(tmp_path / "resources")
    run = json.loads(file.read_text())
    run["mechanism"]["solver"]["max_step"] = 1e-9
    file.write_text(json.dumps(run))
    here, there = socket.socketpair()
    code = "from plymotion.solver.studies.fmu.server import main; import sys; main(sys.argv[1])"
    words = [sys.executable, "-c", code, str(tmp_path / "resources")]
    with there, here, subprocess.Popen(words, stdin=there) as server:
        there.close()
        for answer in (12 + 16, 12 + 8):  # counts, start of the inputs
            assert len(here.recv(answer, socket.MSG_WAITALL)) == answer
        here.sendall(struct.pack("=ii3d", START, 3, 2.0, 1.0, 1.0))
        assert len(here.recv(20, socket.MSG_WAITALL)) == 20
        here.sendall(struct.pack("=ii5d", STEP, 5, 1.0, 0.0, 1.0, 0.0, 0.0))
        time.sleep(0.2)
        assert server.poll() is None
        here.close()
        try:
            assert server.wait(timeout=20) == 0
        finally:
            server.kill()
