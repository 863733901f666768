"""The paper's double pendulum, and its limits, from the shipped packages: no FEniCSx needed."""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness.processes import this_python
from samples.case_samples import case_runs

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.results.codes import SPIN
from plymotion.solver.run.execution import execute, read_run

CASE = "cases/double-pendulum/case.toml"
SHIPPED = "tests/packages/double-pendulum"
LIMITS = "double-pendulum-limits"


REFERENCE = "double_pendulum"


@pytest.fixture(scope="module")
def checked(repository, tmp_path_factory):
    """A build folder of the case that uses the shipped packages."""
    folder = tmp_path_factory.mktemp("checked")
    write_case(load_case(repository / CASE, sweeps=()), folder, repository / SHIPPED)
    return folder


@pytest.fixture(scope="module")
def limits(repository, tmp_path_factory):
    """Run files of the case at the limits of linear bodies."""
    return case_runs(repository, LIMITS, tmp_path_factory.mktemp("limits"))


@pytest.fixture
def build(checked, tmp_path, monkeypatch):
    """A copy of it for one test."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(checked, tmp_path, dirs_exist_ok=True))


def _edited(
    build: Path, repository: Path, *changes: tuple[str, str], name: str = "double-pendulum"
) -> Path:
    """A case with some text replaced, checked into `build`."""
    source = (repository / "cases" / name / "case.toml").read_text()
    for old, new in changes:
        assert old in source
        source = source.replace(old, new)
    folder = build / "edited"
    folder.mkdir()
    file = folder / "case.toml"
    file.write_text(source)
    write_case(load_case(file, sweeps=()), build, repository / "tests/packages" / name)
    return build / "runs"


def test_isotropic_run_against_geometrically_exact_beams(build, reference):
    expected = reference["isotropic"]
    result, summary = execute(read_run(build / "runs/isotropic.json"), progress=False)
    signals = {s.name: s.values for s in result.signals}
    assert summary["completed"]
    assert summary["t_end"] == 1.0
    tip = np.array([signals["tip_x"][-1], signals["tip_y"][-1]])
    assert np.linalg.norm(tip - expected["tip"]) < expected["tip_tolerance"]
    for name in ("arm_mid", "hand_mid"):
        largest = np.abs(signals[name]).max()
        allowed = expected[f"{name}_tolerance"] * expected[f"{name}_max"]
        assert abs(largest - expected[f"{name}_max"]) < allowed, name
    assert summary["checks"]["constraint_position_max"] < 1e-6
    assert summary["checks"]["energy_drift_relative"] < 1e-6
    assert summary["warnings"] == []


def test_soft_free_run_stops_where_the_linear_hand_loses_definiteness(limits, reference):
    expected = reference["isotropic-soft-free"]
    result, summary = execute(read_run(limits / "isotropic-soft-free.json"), progress=False)
    assert not summary["completed"]
    assert abs(summary["t_end"] - expected["crossing"]) < expected["crossing_tolerance"]
    assert summary["warnings"][0]["code"] == SPIN.name
    assert "geometric_stiffening = true" in summary["message"]
    assert result.t.size > 100
    assert result.t[-1] == summary["t_end"]
    # The spin of the hand at the stop is its first clamped frequency, tip mass included.
    spin = np.linalg.norm(result.v[-1][10 + 3 : 10 + 6])
    assert abs(spin - expected["critical_spin"]) < expected["critical_spin_tolerance"]


def test_soft_free_run_can_be_told_to_go_on(build, repository):
    change = ("t_end = 1.0", 't_end = 0.13\non_invalid = "warn"')
    runs = _edited(build, repository, change, name=LIMITS)
    _, summary = execute(read_run(runs / "isotropic-soft-free.json"), progress=False)
    assert summary["completed"]
    assert [w["code"] for w in summary["warnings"]].count(SPIN.name) == 1


def test_following_hand_without_gravity_shows_no_bending(build, repository):
    """The whole turns as one rigid body at the driven speed: nothing bends it."""
    runs = _edited(
        build,
        repository,
        ("gravity = [0.0, -9.81, 0.0]", "gravity = [0.0, 0.0, 0.0]"),
        ("rtol = 1e-6 #", "rtol = 1e-9 #"),
        name=LIMITS,
    )
    result, summary = execute(read_run(runs / "layup-1-soft-following.json"), progress=False)
    signals = {s.name: s.values for s in result.signals}
    assert summary["completed"]
    angle = 20.0 * result.t
    np.testing.assert_allclose(signals["tip_x"], 1.22 * np.cos(angle), atol=1e-7)
    np.testing.assert_allclose(signals["tip_y"], 1.22 * np.sin(angle), atol=1e-7)
    assert np.abs(signals["arm_mid"]).max() < 1e-8
    assert np.abs(signals["hand_mid"]).max() < 1e-8


def test_shipped_packages_are_those_of_the_case(build, limits):
    """Their inputs are the case's: `make ship` after a change of the bodies."""
    for run in [*(build / "runs").glob("*.json"), *limits.glob("*.json")]:
        assert set(read_run(run).packages) == {"arm", "hand"}


def _copy_packages(build: Path, repository: Path) -> Path:
    folder = build / "copies"
    shutil.copytree(repository / SHIPPED, folder)
    write_case(load_case(repository / CASE, sweeps=()), build, folder)
    return folder / "hand.isotropic.vtkhdf"


def _fails(build: Path, capsys) -> str:
    out = build / "out"
    run = str(build / "runs/isotropic.json")
    assert main(["run", run, "--out", str(out), "--quiet"]) == 2
    assert not out.exists()
    return capsys.readouterr().err


def test_truncated_package(build, repository, capsys):
    file = _copy_packages(build, repository)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    message = _fails(build, capsys)
    assert "hand.isotropic.vtkhdf" in message
    assert "truncated" in message


def test_foreign_package(build, repository, capsys):
    file = _copy_packages(build, repository)
    file.unlink()
    with h5py.File(file, "w") as foreign:
        foreign["mesh/points"] = np.zeros((3, 3))
    assert "hand.isotropic.vtkhdf" in _fails(build, capsys)


def test_package_of_a_newer_format(build, repository, capsys):
    file = _copy_packages(build, repository)
    with h5py.File(file, "a") as newer:
        newer.attrs["format_version"] = np.array([2, 0])
    message = _fails(build, capsys)
    assert "hand.isotropic.vtkhdf" in message
    assert "newer" in message
    assert "2.0" in message


def test_package_of_other_inputs(build, repository, capsys):
    file = _copy_packages(build, repository)
    shutil.copy(file.with_name("hand.layup-1.vtkhdf"), file)
    assert "built from other inputs" in _fails(build, capsys)


def test_mechanism_that_cannot_be_assembled(build, repository, capsys):
    _edited(
        build,
        repository,
        (
            "[joints.elbow]",
            '[ground.far]\nposition = [3.0, 0.0, 0.0]\n\n[joints.far]\nkind = "revolute"\n'
            'between = ["ground.far", "hand.tip"]\n\n[joints.elbow]',
        ),
    )
    message = _fails(build, capsys)
    assert "cannot be assembled" in message
    assert "m apart" in message
    assert "far" in message


def test_contradictory_start(build, repository, capsys):
    _edited(
        build,
        repository,
        (
            "position = [0.0, 0.0, 0.0]\ninterfaces",
            "position = [0.0, 0.0, 0.0]\nangular_velocity = [0.0, 0.0, 5.0]\ninterfaces",
        ),
    )
    message = _fails(build, capsys)
    assert "initial velocities contradict" in message
    assert "shoulder (drive): 0 m/s, 15 rad/s" in message


def test_plain_numpy_gives_the_same_motion(build, repository):
    """The compiled path and plain NumPy are one set of formulas."""
    code = (
        "import sys, json; from pathlib import Path\n"
        "from plymotion.solver.run.execution import execute, read_run\n"
        "from plymotion.solver.math.compiled import COMPILED\n"
        "spec = read_run(Path('runs/isotropic.json')).changed({'solver.t_end': 0.002})\n"
        "result, _ = execute(spec, progress=False)\n"
        "print(json.dumps([COMPILED, result.q[-1].tolist()]))\n"
    )
    found = {}
    for flag in ("0", "1"):
        done = this_python("-c", code, more={"PLYMOTION_COMPILED": flag}, cwd=build, check=True)
        compiled, q = json.loads(done.stdout)
        found[flag] = np.array(q)
        assert not (flag == "0" and compiled)
    np.testing.assert_allclose(found["0"], found["1"], atol=1e-10)


def test_output_that_cannot_be_written_is_an_error_with_words(build, capsys):
    (build / "out").write_text("a file where a folder should be")
    run = str(build / "runs/isotropic.json")
    assert main(["run", run, "--out", str(build / "out"), "--quiet"]) == 2
    assert "out: File exists" in capsys.readouterr().err


def test_stiffened_soft_pendulum_completes_against_geometrically_exact_beams(limits, reference):
    """The run that no linear body survives: chord frames, two static and two vibration modes."""
    expected = reference["isotropic-soft-free"]
    spec = read_run(limits / "isotropic-soft-free-stiffened.json")
    result, summary = execute(spec, progress=False)
    assert summary["completed"]
    assert summary["checks"]["modes_used"] == {"arm": 4, "hand": 4}
    signals = {s.name: s.values for s in result.signals}
    tip = np.array([signals["tip_x"][-1], signals["tip_y"][-1]])
    assert np.linalg.norm(tip - expected["tip"]) < expected["stiffened_chord_tip_tolerance"]
    middle = 0.2725 * np.abs(signals["arm_mid"]).max()  # the signal is over half the length
    assert abs(middle / expected["arm_mid"] - 1.0) < expected["arm_mid_tolerance"]
    assert summary["checks"]["energy_drift_relative"] < 1e-7
    assert summary["checks"]["momentum_balance"] < 1e-9
    codes = [warning["code"] for warning in summary["warnings"]]
    assert "elastic-rotation-large" in codes
    assert not {SPIN.name, "buckling-by-motion", "stiffening-matters"} & set(codes)
