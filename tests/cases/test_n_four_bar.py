"""N four-bar mechanisms through their singular positions: the exact branch, and only that."""

import subprocess
import sys
import tomllib

import numpy as np
import pytest
from case_samples import case_runs, run_case


@pytest.fixture(scope="module")
def reference(repository):
    file = repository / "tests/reference/dynamics/a02_n_four_bar.toml"
    return tomllib.loads(file.read_text())


@pytest.fixture(scope="module")
def runs(repository, tmp_path_factory):
    return case_runs(repository, "n-four-bar", tmp_path_factory.mktemp("build"))


@pytest.mark.parametrize("name", ["n-2", "n-2-hinges"])
def test_two_loops_for_ten_seconds(name, runs, reference):
    """Ten singular passes; redundant hinges move like independent ones."""
    t, s, summary = run_case(runs / f"{name}.json")
    found = np.array([s["x"], s["y"]]).T
    assert summary["completed"]
    for at, expected in ((4.0, "at_4"), (10.0, "exact"), (10.0, "published")):
        error = np.linalg.norm(found[np.searchsorted(t, at)] - reference["n-2"][expected])
        assert error < reference["tolerance"], (at, expected)
    drift = summary["checks"]["energy_drift_relative"]
    assert drift * 50.0 < reference["energy_tolerance"]  # 50 J in play
    assert summary["checks"]["degrees_of_freedom"] == 1


def test_forty_loops_pass_their_first_singular_position(runs, reference):
    t, s, summary = run_case(runs / "n-40.json", t_end=0.8, rtol=1e-7)
    assert summary["completed"]
    below = np.flatnonzero(s["y"] < 0.0)[0]
    crossing = np.interp(0.0, -s["y"][below - 1 : below + 1], t[below - 1 : below + 1])
    assert crossing == pytest.approx(reference["n-40"]["first_pass"], abs=1e-4)


def test_the_case_is_what_its_generator_writes(repository):
    folder = repository / "cases/n-four-bar"
    command = [sys.executable, str(folder / "generate.py"), "four-bars", "2", "40"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == (folder / "case.toml").read_text()


def test_generated_chain_is_a_case(repository, tmp_path):
    """Three links let go level: the energy is kept, the first link starts to fall."""
    from plymotion.solver.case import load_case
    from plymotion.solver.case.specs import write_case

    command = [sys.executable, str(repository / "cases/n-four-bar/generate.py"), "chain", "3"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (tmp_path / "case.toml").write_text(done.stdout)
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    _, s, summary = run_case(tmp_path / "build/runs/base.json", t_end=0.3)
    assert summary["checks"]["degrees_of_freedom"] == 3
    assert summary["checks"]["energy_drift_relative"] < 1e-8
    assert s["y"][-1] < -0.1
