"""`import plymotion` in Python: what it loads, cases, runs and results by name."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from harness.processes import this_python
from samples.case_samples import HEAD, SOLVER, rigid

import plymotion as pm
from plymotion.solver.__main__ import main as command
from plymotion.solver.commands.case import report_case
from plymotion.solver.inputs.case.tables.schema import CaseFile, Mechanism
from plymotion.solver.studies.cases import folder_lock

SWING = (
    HEAD
    + "gravity = [0.0, 0.0, -9.81]\n"
    + rigid("rod", 2.0, 0.1, {"root": (0, 0, 0), "tip": (1, 0, 0)}, centre=[0.5, 0.0, 0.0])
    + """
[ground.hinge]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.hinge", "rod.root"]
axis = [0.0, 1.0, 0.0]
[signals.tip_z]
kind = "position"
at = "rod.tip"
component = "z"
[signals.speed]
kind = "velocity"
at = "rod.tip"
component = "magnitude"
"""
    + SOLVER.format(t_end=0.5, step=0.01, more="")
    + "[runs.moon]\nvariants = ['moon']\n[variants.moon]\ngravity = [0.0, 0.0, -1.62]\n"
)


@pytest.fixture
def swing(tmp_path, monkeypatch):
    """The file of a rigid pendulum in the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("swing.toml").write_text(SWING)
    return "swing.toml"


def test_import_loads_no_library(repository):
    code = (
        "import sys; before = set(sys.modules); import plymotion; print(*set(sys.modules) - before)"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, cwd=repository, check=True)
    loaded = {name.split(".")[0] for name in done.stdout.split()}
    assert not loaded & {"numpy", "h5py", "pydantic", "scipy", "numba", "tqdm", "matplotlib"}
    assert not [name for name in done.stdout.split() if name.startswith("plymotion.")]


def test_all_names_are_there_and_others_are_not():
    assert dir(pm) == pm.__all__, "neither os nor modules of the package, and no name twice"
    for name in pm.__all__:
        assert getattr(pm, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'simulation'"):
        pm.simulation  # noqa: B018


def test_stub_has_every_public_name(repository):
    stub = (repository / "plymotion/__init__.pyi").read_text("utf-8")
    for name in pm.__all__:
        assert f"import {name} as {name}\n" in stub or name == "__version__", name


def test_numbers_are_those_of_the_command(swing, tmp_path):
    result = pm.run(swing, "moon", out="by-python")
    assert command([swing, "--out", "by-command", "--no-report", "--quiet"]) == 0
    other = pm.Result.from_folder("by-command/moon")
    assert np.array_equal(result.data.q, other.data.q)
    assert np.array_equal(result.signals["tip_z"].values, other.signals["tip_z"].values)
    assert result.summary["inputs_sha256"] == other.summary["inputs_sha256"]
    # what the command has computed is not computed again, and the other way round
    before = (other.folder / "result.vtkhdf").stat().st_mtime_ns
    again = pm.run(swing, "moon", out="by-command")
    assert (again.folder / "result.vtkhdf").stat().st_mtime_ns == before
    pm.run(swing, "moon", out="by-command", force=True)
    assert (again.folder / "result.vtkhdf").stat().st_mtime_ns > before


def test_a_case_built_in_python_is_that_of_the_file(swing):
    case = pm.Case("swing", gravity=np.array([0.0, 0.0, -9.81]))
    case.bodies["rod"] = {
        "kind": "rigid",
        "mass": np.float64(2.0),
        "inertia": 0.1 * np.eye(3),
        "centre": (0.5, 0, 0),
        "interfaces": {"root": {"position": [0, 0, 0]}, "tip": {"position": [1, 0, 0]}},
    }
    case.ground["hinge"] = {"position": np.zeros(3)}
    between = ["ground.hinge", "rod.root"]
    case.joints["hinge"] = {"kind": "revolute", "between": between, "axis": [0, 1, 0]}
    case.signals["tip_z"] = {"kind": "position", "at": "rod.tip", "component": "z"}
    case.solver = pm.load(swing).solver
    found = pm.run(case, out="built")
    assert np.array_equal(found.signals["tip_z"].values, pm.run(swing, "base").signals["tip_z"])


def test_changed_leaves_the_case_alone(swing):
    case = pm.load(swing)
    other = case.changed({"bodies.rod.mass": 3.0, "joints.hinge.axis.0": 0.0, "solver.t_end": 0.1})
    assert case.bodies["rod"]["mass"] == 2.0
    assert other.bodies["rod"]["mass"] == 3.0
    assert pm.run(other, "base", out="other").t[-1] == 0.1
    with pytest.raises(pm.InputError, match=r"gravity\.7: the case has no such key"):
        case.changed({"gravity.7": 1.0})


def test_numbers_and_starts_follow_a_changed_parameter(swing):
    """What was computed of the old one does not stay: mass, start of a joint, laws."""
    case = pm.load(swing)
    case.table["parameters"] = {"L": 1.0}
    case.bodies["rod"]["mass"] = "2 * L"
    case.joints["hinge"]["start_deg"] = "30 * L"
    for length in (1.0, 2.0):
        found = case.changed({"parameters.L": length}).check().runs["base"]
        assert found.bodies["rod"].mass == 2.0 * length
        assert found.joints["hinge"].start_deg == 30.0 * length


def test_wrong_names_and_wrong_cases_say_so(swing):
    case = pm.load(swing)
    case.bodies["ground"] = case.bodies["rod"]  # joints at "ground.hinge" would not mean it
    with pytest.raises(pm.InputError, match=r"bodies\.ground: expected another name"):
        case.check()
    with pytest.raises(pm.InputError, match=r"Case\(3\): expected a name"):
        pm.Case(3)
    with pytest.raises(pm.InputError, match=r"--at 5.0: expected start, "):
        pm.modes(swing, "base", at=5.0)
    with pytest.raises(pm.InputError, match="expected the name of a run: base, moon"):
        pm.run(swing)
    with pytest.raises(pm.InputError, match="no run 'mon'; did you mean 'moon'"):
        pm.run(swing, "mon")
    with pytest.raises(KeyError, match="no 'tipz' among the signals; did you mean 'tip_z'"):
        pm.run(swing, "base").signals["tipz"]
    with pytest.raises(pm.InputError, match=r"gone/summary\.json: no such file"):
        pm.Result.from_folder("gone")
    result = pm.run(swing, "base")
    with pytest.raises(pm.InputError, match=r"expected the folder of a run, such as \S*base"):
        pm.Result.from_folder(result.folder.parent)
    with pytest.raises(pm.InputError, match="letters, digits"):
        pm.Case("../above")
    case = pm.load(swing)
    case.bodies["rod"]["mas"] = 1.0
    with pytest.raises(pm.InputError, match=r"swing\.toml: bodies\.rod\.mas: unknown key"):
        pm.run(case, "base")


def test_a_result_keeps_its_numbers_when_its_folder_gets_another(swing, monkeypatch):
    """Signals are read when they are asked for; a later run may have replaced the file by then."""
    case = pm.load(swing)
    first = pm.run(case, "base")
    wanted = pm.Result.from_folder(first.folder).signals["tip_z"].final
    case.gravity = [0.0, 0.0, -1.62]
    second = pm.run(case, "base")
    assert second.signals["tip_z"].final > wanted + 0.1
    assert first.signals["tip_z"].final == wanted
    left, gone = pm.Result(second.folder), pm.Result(second.folder)
    monkeypatch.chdir("build")  # results are found from everywhere
    assert second.summary["run"] == pm.Result("swing/base").run
    file = Path("swing/base/result.vtkhdf")
    file.with_name("other").write_bytes(file.read_bytes())
    file.with_name("other").replace(file)  # as another process does
    with pytest.raises(pm.InputError, match=r"result.vtkhdf: a later run has replaced it; exp"):
        _ = left.signals
    assert pm.Result("swing/base").signals["tip_z"].final == second.signals["tip_z"].final
    file.unlink()
    with pytest.raises(pm.InputError, match=r"result.vtkhdf: no such file"):
        _ = gone.signals


@pytest.mark.parametrize("case", [{"format": 1}, None])
def test_what_is_no_case_says_so(case):
    with pytest.raises(pm.InputError, match="expected a Case, or the path of a case file"):
        pm.run(case)


def test_every_key_of_a_case_file_is_an_attribute_and_others_are_refused(swing):
    case = pm.load(swing)
    for key in {**CaseFile.model_fields, **Mechanism.model_fields}:
        getattr(case, key)
    assert case.fidelity is None, "to look at a key does not write it"
    case.check()
    case.gravity = (0.0, 0.0, -1.62)
    assert case.check().runs["base"].gravity == [0.0, 0.0, -1.62]
    with pytest.raises(AttributeError):
        case.gravty = (0.0, 0.0, 0.0)


def test_keys_are_attributes_at_every_depth(swing):
    case = pm.load(swing)
    case.solver.rtol = 1e-4
    case.joints.hinge.axis = np.array([0.0, 2.0, 0.0])
    case.bodies.rod.interfaces.middle = {"position": (0.5, 0.0, 0.0)}
    case.variants.heavy = {"bodies": {"rod": {"mass": 3.0}}}
    case.runs.heavy = {"variants": ["heavy"]}
    assert case.table["solver"]["rtol"] == 1e-4
    assert case.check().runs["heavy"].bodies["rod"].mass == 3.0
    assert case.variants.heavy.bodies.rod.mass == 3.0
    del case.solver.integrator
    assert case.solver.integrator == "radau", "an absent key reads as its default"
    assert {"rtol", "t_end", "integrator"} <= set(dir(case.solver))
    assert {"mass", "inertia"} <= set(dir(case.bodies.rod))
    assert "plies" not in dir(case.bodies.rod), "only keys of its kind"
    assert dir(case.bodies) == ["rod"]
    case.coarse.solver.rtol = 1e-2
    assert case.table["coarse"] == {"solver": {"rtol": 1e-2}}


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("case.solver.rtol = -1", r"solver\.rtol = -1: value should be greater"),
        ("case.solver.rtoll = 1e-3", r"solver\.rtoll: unknown key; did you mean 'rtol'"),
        ("case.solver.integrator = 'rado'", r"solver\.integrator = .*; did you mean 'radau'"),
        ("case.bodies.rod.mass = '2'", r'bodies\.rod\.mass = "2": value should be a valid number'),
        ("case.bodies.arm = {'kind': 'rigd'}", r"bodies\.arm\.kind = .*did you mean 'rigid'"),
        ("case.gravity = [1.0]", r"gravity = \[1.0\]: expected a list of 3 numbers"),
        ("case.bodies.rd", r"bodies\.rd: unknown key; did you mean 'rod'"),
        ("case.variants = {'a': {}}; case.variants.a.solver.rtol = 0", r"a\.solver\.rtol = 0"),
    ],
)
def test_a_wrong_key_or_value_of_an_attribute_says_so_at_once(swing, statement, message):
    case = pm.load(swing)
    before = {**case.table}
    with pytest.raises(pm.InputError, match=message):
        exec(statement, {"case": case})
    assert case.table["solver"] == before["solver"]


def test_measures_are_of_finite_values():
    """As in tables and summary.json: a strength ratio is infinite at instants without stress."""
    values = np.array([np.inf, 4.0, np.nan, 2.0, 3.0])
    ratio = pm.Signal("R", "-", "", np.arange(5.0), values)
    assert (ratio.max, ratio.t_of_max, ratio.min, ratio.t_of_min) == (4.0, 1.0, 2.0, 3.0)
    assert ratio.peak_to_peak == 2.0
    never = pm.Signal("R", "-", "", np.arange(5.0), np.full(5, np.inf))
    measures = never.max, never.t_of_max, never.min, never.t_of_min, never.peak_to_peak, never.rms
    assert np.isnan(measures).all()
    assert never.final == np.inf


def test_arithmetic_of_signals(swing):
    base, moon = pm.run(swing, "base"), pm.run(swing, "moon")
    error = base.signals["tip_z"] - moon.signals["tip_z"]
    z, z_moon = base.signals["tip_z"].values, moon.signals["tip_z"].values
    assert np.array_equal(error.values, z - z_moon)
    assert error.unit == "m"
    assert error.final == z[-1] - z_moon[-1]
    assert (abs(error) + 1.0).min == 1.0
    assert (error / 2.0).peak_to_peak == pytest.approx(0.5 * np.ptp(z - z_moon))
    assert np.array_equal((-error).values, z_moon - z)
    assert np.array_equal((1.0 - error).values, 1.0 - error.values)
    for number in (2.0, np.float64(2.0)):
        assert np.array_equal((number * error).values, 2.0 * error.values)
        assert (number + error).unit == "m"
    length = pm.norm(base.signals["tip_z"], base.signals["tip_z"])
    assert length.values == pytest.approx(np.sqrt(2.0) * np.abs(z))
    with pytest.raises(pm.InputError, match="expected the same unit, found m and m/s"):
        base.signals["tip_z"] - base.signals["speed"]
    with pytest.raises(TypeError, match="unsupported operand"):
        error * error
    with pytest.raises(TypeError, match="unsupported operand"):
        error + "1"
    with pytest.raises(pm.InputError, match="expected at least one signal"):
        pm.norm()


def test_difference_ends_with_the_shorter_run(swing):
    case = pm.load(swing)
    short = pm.run(case.changed({"solver.t_end": 0.2}), "base", out="short")
    error = pm.run(case, "base").signals["tip_z"] - short.signals["tip_z"]
    assert np.isfinite(error.values[:21]).all()
    assert np.isnan(error.values[21:]).all()
    assert error.max == pytest.approx(0.0, abs=1e-9)


def test_notebooks_get_tables_and_pictures(swing):
    result = pm.run(swing, "base")
    for thing in (pm.load(swing), result, result.signals, result.signals["speed"]):
        page = thing._repr_html_()
        assert page.startswith("<table>")
        assert page.count("<table>") == page.count("</table>")
    assert result._repr_html_().count("<svg") == 2
    assert result.signals._ipython_key_completions_() == ["tip_z", "speed"]
    low = json.loads((result.folder / "summary.json").read_text())["signals"]["tip_z"]["min"]
    assert f"{low:.6g}" in result._repr_html_()


def test_without_pandas_the_message_says_how_to_get_it(swing, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="expected pip install pandas"):
        pm.run(swing, "base").to_pandas()


def test_a_figure_of_the_case_may_be_a_spectrum(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    figure = '[figures.hum]\ntitle = "Hum"\nsignal = "tip_z"\nruns = ["base"]\nspectrum = true\n'
    Path("swing.toml").write_text(SWING + figure)
    assert command(["swing.toml", "--run", "base", "--figures", "--quiet"]) == 0
    assert Path("build/swing/hum.png").stat().st_size > 1000
    short = figure.replace("hum", "short") + "[variants.brief.solver]\noutput_step = 0.5\n"
    runs = '[runs.brief]\nvariants = ["brief"]\n'
    Path("swing.toml").write_text(SWING + short.replace('"base"', '"brief"') + runs)
    pm.run("swing.toml", "brief")
    with pytest.raises(pm.InputError, match=r"figures\.short: run brief: .*four output times"):
        report_case(Path("build/swing"), ["brief"])


def test_a_sweep_is_that_of_the_command_and_is_continued(swing):
    text = "[sweeps.mass]\nrun = 'base'\nvary.'gravity.2' = [-9.81, -1.62]\n"
    Path(swing).write_text(SWING + text)
    found = pm.sweep(swing, "mass", out="a")
    moon = pm.run(swing, "moon", out="a").signals["tip_z"]
    assert found.signals["tip_z"].min[1] == pytest.approx(moon.min, rel=1e-12)
    assert found.signals["tip_z"].rms[1] == pytest.approx(moon.rms, rel=1e-12)
    assert command(["sweep", "a/sweeps/mass.json", "--quiet", "--no-figures"]) == 0
    again = pm.Sweep.from_folder("a/sweeps/mass")
    assert again.data.rows == found.data.rows  # with the times that they took
    assert Path("a/sweeps/mass/sweep.csv").is_file()


def test_a_sweep_by_processes_needs_no_guard_in_the_script(swing, tmp_path, repository):
    script = tmp_path / "script.py"
    script.write_text(
        "import plymotion as pm\n"
        f"found = pm.sweep({swing!r}, run='base', vary={{'bodies.rod.mass': [1, 2, 3]}}, jobs=2)\n"
        "print(found.status)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(repository)}
    done = this_python(script, env=environment)
    assert done.returncode == 0, done.stderr
    assert "['finished', 'finished', 'finished']" in done.stdout


def test_arguments_of_a_sweep_that_would_be_ignored_are_refused(swing):
    with pytest.raises(pm.InputError, match="expected the name of a sweep, or vary="):
        pm.sweep(swing)
    with pytest.raises(pm.InputError, match="signals belongs to a new sweep; expected vary="):
        pm.sweep(swing, "masses", signals=["tip_z"])
    with pytest.raises(pm.InputError, match=r"bodies\.rod\.mass = 2: expected a list of values"):
        pm.sweep(swing, run="base", vary={"bodies.rod.mass": 2})
    found = pm.sweep(swing, run="base", vary={"bodies.rod.mass": range(1, 3)})
    with pytest.raises(pm.InputError, match="no measure 'maxi'; did you mean 'max'"):
        found.plot("tip_z", "maxi")
    with pytest.raises(pm.InputError, match="tip_z: its values over time were not kept"):
        _ = found.signals["tip_z"].history


def test_wrong_sweeps_say_so(swing):
    with pytest.raises(pm.InputError, match="no sweep 'mas'"):
        pm.sweep(swing, "mas")
    with pytest.raises(pm.InputError, match="expected the name of a run: base, moon"):
        pm.sweep(swing, vary={"bodies.rod.mass": [1.0]})
    with pytest.raises(pm.InputError, match=r"sweeps\.python\.vary: .* did you mean 'mass'"):
        pm.sweep(swing, run="base", vary={"bodies.rod.mas": [1.0]})
    with pytest.raises(pm.InputError, match=r"member 1: bodies.rod.mass = -1\)"):
        pm.sweep(swing, run="base", vary={"bodies.rod.mass": [1.0, -1.0]})


def test_two_processes_take_turns_in_a_folder(swing, tmp_path):
    """As commands do: the second one waits until the first one has ended."""
    pytest.importorskip("fcntl")
    code = (
        "import plymotion as pm\n"
        f"found = pm.run({swing!r}, 'base', out='out', progress=True)\n"
        f"swept = pm.sweep({swing!r}, run='base', vary={{'gravity.2': [-1.0]}}, out='out')\n"
        "print(found.signals['tip_z'].min, swept.status)\n"
    )
    with folder_lock(tmp_path / "out"):
        process = subprocess.Popen(
            [sys.executable, "-c", code],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"PLYMOTION_COMPILED": "0"},
        )
        assert process.stderr.readline() == "out: waiting for another command\n"
        assert not list((tmp_path / "out").iterdir())
    out, told = process.communicate(timeout=600)
    assert process.returncode == 0, told
    assert "['finished']" in out
