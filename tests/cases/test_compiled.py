"""What Numba compiles is kept: a process after `plymotion solver compile` compiles nothing."""

import json
import shutil
from importlib.util import find_spec

import pytest
from harness.processes import this_python

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case

# Not `importorskip`: Numba takes long to load, and each worker of pytest reads this file.
pytestmark = pytest.mark.skipif(find_spec("numba") is None, reason="Numba is not installed")

# The runs of FILES (name: file and changes of its solver), each in a process of its own: a fork of
# one that has read their files and packages and called no compiled function. Each writes, as a
# line, its name, the names of functions that had to be compiled, the number of those that were
# loaded, and which libraries of compilers were imported.
EACH_RUN = """
import gc, json, os, sys
from pathlib import Path
from plymotion.solver.math.compiled import statistics
from plymotion.solver.run.execution import execute, read_run
specs = {}
for name, (file, options) in json.loads(sys.argv[1]).items():
    specs[name] = read_run(Path(file)).changed({f"solver.{k}": v for k, v in options.items()})
gc.collect(), gc.freeze()
assert not statistics.loaded and not statistics.compiled
for name, spec in specs.items():
    if os.fork():
        assert os.wait()[1] == 0, f"{name} failed, see above"
        continue
    result, summary = execute(spec, progress=False)
    assert summary["completed"], summary
    imported = [each for each in ("numba", "llvmlite") if each in sys.modules]
    row = [name, statistics.compiled, len(statistics.loaded), imported]
    print(json.dumps(row), flush=True)
    break
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
    "controlled-arm": ("stopped", {"t_end": 0.002}),
}


@pytest.fixture(scope="module")
def ahead():
    """Everything compiled, as `make` does before its first run."""
    words = _python(
        "from plymotion.solver.studies.compiling import compile_ahead\n"
        "if __name__ == '__main__':\n"
        "    print(compile_ahead(everything=True))\n"
    )
    if "not kept" in words:
        pytest.skip("compiled code cannot be kept here: no folder for it can be written")


def _python(code: str, *arguments: str) -> str:
    done = this_python("-c", code, *arguments, more={"PLYMOTION_COMPILED": "1"})
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def found(ahead, repository, tmp_path_factory):
    """What each run compiled and loaded, by its name."""
    build = tmp_path_factory.mktemp("compiled")
    files = {}
    for name, (run, options) in RUNS.items():
        case = name.split(" ")[0]
        folder = build / case
        if not folder.exists():
            packages = repository / "tests" / "packages" / case
            write_case(
                load_case(repository / "cases" / case / "case.toml", sweeps=()),
                folder,
                packages if packages.is_dir() else None,
            )
        # the outputs of the case may be further apart than the end
        options = {**options, "output_step": 0.5 * float(str(options["t_end"]))}
        files[name] = (str(folder / f"runs/{run}.json"), options)
    rows = [json.loads(line) for line in _python(EACH_RUN, json.dumps(files)).splitlines()]
    return {name: row for name, *row in rows}


def test_what_is_in_the_cache_is_not_compiled_ahead_again(ahead):
    _python(
        "from plymotion.solver.studies import compiling\n"
        "def again():\n"
        "    raise AssertionError('called again')\n"
        "compiling.compile_ahead = again\n"
        "compiling.compile_once()\n"
    )


@pytest.mark.parametrize("name", RUNS)
def test_a_run_compiles_nothing(name, found):
    missed, loaded, imported = found[name]
    assert not missed, missed
    assert loaded > 5
    # all comes from the library, where one could be linked
    assert imported == ([] if shutil.which("cc") else ["llvmlite"])


def test_planning_compiles_nothing(ahead, repository):
    """A plan of [fidelity], and its checks."""
    words = _python(
        "import sys; sys.path[:0] = sys.argv[1:]\n"
        "from samples.fidelity_samples import pendulum, planned_run\n"
        "from plymotion.solver.studies.fidelity.checked_run import checked, plan_of\n"
        "from plymotion.solver.math.compiled import statistics\n"
        "table = pendulum(t_end=0.1)\n"
        "print(checked(plan_of(*planned_run(table, 'soft'))).verdict, statistics.compiled)\n",
        str(repository / "tests"),
    )
    assert words.split() == ["met", "[]"], words
