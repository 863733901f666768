"""The spin-up manoeuvre from the shipped packages: no FEniCSx needed."""

from dataclasses import replace as _replace

import numpy as np
import pytest

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.results.codes import BUCKLING, MATTERS, NO_STIFFENING_DATA, SPIN
from plymotion.solver.run.execution import execute, read_run

REFERENCE = "spin_up"


@pytest.fixture
def build(repository, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    case = load_case(repository / "cases/spin-up/case.toml")
    write_case(case, tmp_path, repository / "tests/packages/spin-up")
    return tmp_path


def ran(build, run, **solver):
    changes = {f"solver.{key}": value for key, value in solver.items()}
    spec = read_run(build / f"runs/{run}.json").changed(changes)
    result, summary = execute(spec, progress=False)
    codes = [warning["code"] for warning in summary["warnings"]]
    return result.t, {s.name: s.values for s in result.signals}, summary, codes


@pytest.mark.parametrize("run", ["stiffened", "stiffened-chord"])
def test_stiffened_beam_follows_geometrically_exact_beams(build, reference, run):
    expected = reference["stiffened"]
    t, signals, summary, codes = ran(build, run)
    assert summary["completed"]
    across, along = signals["tip_y"], signals["tip_x"]
    lowest = int(np.argmin(across))
    assert abs(across[lowest] - expected["tip_min"]) < expected["tip_min_tolerance"]
    assert abs(t[lowest] - expected["tip_min_time"]) < expected["tip_min_time_tolerance"]
    on_the_way = np.interp(expected["times"], t, across)
    np.testing.assert_allclose(on_the_way, expected["tip"], atol=expected["tip_tolerance"])
    steady = t > 15.0
    assert abs(along[steady].mean() - expected["extension"]) < expected["extension_tolerance"]
    residual = np.abs(across[steady]).max()
    assert abs(residual / expected["residual"] - 1.0) < expected["residual_tolerance"]
    assert summary["checks"]["energy_drift_relative"] < 1e-6
    assert not {SPIN.name, BUCKLING.name, MATTERS.name, NO_STIFFENING_DATA.name} & set(codes)


def test_linear_beam_diverges_and_is_warned_of_before(build, reference):
    expected = reference["linear"]
    t, signals, summary, codes = ran(build, "linear")
    assert {SPIN.name, MATTERS.name} <= set(codes)
    (message,) = (w["message"] for w in summary["warnings"] if w["code"] == SPIN.name)
    instant = float(message.partition("t = ")[2].split()[0])
    assert abs(instant - expected["unstable_from"]) < expected["unstable_tolerance"]
    tip = signals["tip_y"]
    assert instant < t[np.argmax(np.abs(tip) > 5.0)]  # before it is nonsense
    found = np.interp(expected["times"], t, tip)
    np.testing.assert_allclose(found, expected["tip"], rtol=expected["tip_tolerance"])


def test_package_without_data_runs_linear_and_says_so(build):
    spec = read_run(build / "runs/stiffened.json").changed({"solver.t_end": 0.2})
    package = spec.packages["beam"]
    places = [_replace(i, H_B=None, H_psi_B=None) for i in package.interfaces]
    spec.packages["beam"] = _replace(package, second_order=None, interfaces=tuple(places))
    plain = read_run(build / "runs/linear.json").changed({"solver.t_end": 0.2})
    found, summary = execute(spec, progress=False)
    expected, _ = execute(plain, progress=False)
    assert NO_STIFFENING_DATA.name in [w["code"] for w in summary["warnings"]]
    np.testing.assert_array_equal(found.q, expected.q)
