"""What Numba compiles is kept: a process after `plymotion solver compile` compiles nothing."""

import json
import os
import subprocess
import sys

import pytest

from plymotion.solver.inputs.case import load_case
from plymotion.solver.inputs.case.specs import write_case

pytest.importorskip("numba")

# Names of functions that had to be compiled, and the number of those that were loaded.
COUNT = """
import json, sys
from plymotion.solver.math.compiled import statistics
print(json.dumps([statistics.compiled, len(statistics.loaded), "numba" in sys.modules]))
"""
RUN = """
from pathlib import Path
from plymotion.solver.run.execution import execute, read_run
spec = read_run(Path(NAME)).changed({f"solver.{k}": v for k, v in OPTIONS.items()})
result, summary = execute(spec, progress=False)
assert summary["completed"], summary
"""
RUNS = {
    "double-pendulum": ("isotropic", {"t_end": 0.002}),
    "double-pendulum by Gear": ("isotropic", {"t_end": 0.002, "integrator": "gear"}),
    "double-pendulum through virtual bodies": (
        "isotropic",
        {"t_end": 0.001, "attachment": "virtual"},
    ),
    "double-pendulum by generalized-alpha": (
        "isotropic",
        {"t_end": 0.001, "integrator": "generalized-alpha", "constraints": "ggl"},
    ),
    "double-pendulum by Radau": ("isotropic", {"t_end": 0.001, "integrator": "radau"}),
    "double-pendulum by Radau, index 1": (
        "isotropic",
        {"t_end": 0.001, "integrator": "radau", "constraints": "index1"},
    ),
    "n-four-bar by Radau": ("n-2-hinges", {"t_end": 0.05, "integrator": "radau"}),
    "n-four-bar": ("n-2-hinges", {"t_end": 0.05}),
    "slider-crank": ("steel", {"t_end": 0.0005}),
    "misaligned-four-bar": ("flexible", {"t_end": 0.002}),
}


@pytest.fixture(scope="module")
def ahead():
    """Everything compiled, as `make` does before its first run."""
    words = _python(
        "from plymotion.solver.commands.compile import compile_ahead\n"
        "if __name__ == '__main__':\n"
        "    print(compile_ahead(everything=True))\n"
    )
    if "not kept" in words:
        pytest.skip("compiled code cannot be kept here: no folder for it can be written")


def _python(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PLYMOTION_COMPILED": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", RUNS)
def test_a_run_compiles_nothing(name, ahead, repository, tmp_path):
    case = name.split(" ")[0]
    run, options = RUNS[name]
    packages = repository / "tests" / "packages" / case
    write_case(
        load_case(repository / "cases" / case / "case.toml"),
        tmp_path,
        packages if packages.is_dir() else None,
    )
    code = RUN.replace("NAME", repr(str(tmp_path / f"runs/{run}.json")))
    missed, loaded, numba = json.loads(_python(code.replace("OPTIONS", repr(options)) + COUNT))
    assert not missed, missed
    assert loaded > 5
    assert not numba  # not even imported
